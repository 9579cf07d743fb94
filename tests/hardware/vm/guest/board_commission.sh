#!/bin/sh
# The five-bar of docs/examples/five-bar, from its files to a wall that is felt, as its builder goes: the board gets the arm, `thimble commission`
# proves it over the link, and names the motor that is wired backwards. The builder (builder_rig.h) does what the tool prints. Then the measured
# arm goes to the board, with a scene. $UNTIL: the last step; the arm is as commissioned only after step 10.
. /usr/local/bin/lib.sh
. /usr/local/bin/board_lib.sh
device='--device can:vcan0'
until=${UNTIL-10}

load_devices
make_lines
for bus in vcan0 vcan1; do
  ip link add dev $bus type vcan
  ip link set $bus mtu 72 up
done
mkdir /tmp/store /tmp/mine
cp five-bar-odrive.arm.json /tmp/mine
arm=/tmp/mine/five-bar-odrive.arm.json
sed 's/can\([01]\)/vcan\1/; s|/var/lib/thimble|/tmp/store|' five-bar.json >drives.json

start_builder() {
  mkfifo /tmp/prompts /tmp/answers
  builder vcan1 --arm $arm --drive odrive05:0 --drive odrive05:1 --fault "$1" --prompts /tmp/prompts --answers /tmp/answers \
    --e-stop $lines/sim_gpio0/pull --dead-man $lines/sim_gpio1/pull >/tmp/built 2>&1 &
  builder=$!
  wait_until 20 grep -qx ready /tmp/built
}
builder_lives() { kill -0 $builder || die "the builder ended: $(cat /tmp/built)"; }
# commission [OPTION]...: into /tmp/commissioned; the builder reads what it prints.
commission() {
  builder_lives
  status=0
  thimble commission $arm $device "$@" >/tmp/commissioned 2>/tmp/prompts </tmp/answers || status=$?
  builder_lives
}
# most NAME STEP: the most that the motors did before this step: most_N or most_m_s.
most() { sed -n "s/^before step $2: .*\"$1\": \([0-9.]*\).*/\1/p" /tmp/built | tail -n 1; }
below() { awk "BEGIN { exit !($1 < $2) }"; }
passed_step() { grep -A 1000 "^step $1 of" /tmp/built | grep -m 1 '^  passed' >/dev/null; }

step 'the board gets the arm'
start_builder motor-sign@first
tail -f /tmp/built &
start_board drives.json
release_all
thimble model upload $arm $device
release_all  # the board has started anew

step 'commissioning'
if [ $until = 10 ]; then
  commission
  [ $status = 0 ] || die "the commissioning ended with $status: $(tail -n 5 /tmp/built; thimble fault list $device; kill $board; wait $board || true; cat /tmp/board.err)"
else
  for number in $(echo ${STEPS-$(seq 0 $until)} | tr , ' '); do
    commission --step $number
    [ $status = 0 ] || die "step $number ended with $status: $(tail -n 5 /tmp/built; thimble fault list $device; kill $board; wait $board || true; cat /tmp/board.err)"
  done
fi

step 'what the builder was told, and what the arm did'
first=$(grep -n '^  ! ' /tmp/built | head -n 1)
echo "$first"
echo "$first" | grep -q "  ! motor-sign: 'first': the motor turns backwards" || die 'another fault was named first'
[ "$(grep -c '^  ! ' /tmp/built)" = 1 ] || die 'more was named than what is wrong'
[ "$(grep '^  ! \|^step ' /tmp/built | grep -B 1 '^  ! ' | head -n 1 | cut -c1-6)" = 'step 5' ] || die 'not in step 5'
[ "$(grep -c '^<the builder repairs' /tmp/built)" = 1 ] || die 'the builder has not repaired it'
[ $until -lt 6 ] || {
  last=7
  [ $until -gt 6 ] || last=6
  figure "before step $last the tip was pushed with at most $(most most_N $last) N, and at most $(most most_m_s $last) m/s fast"
  below "$(most most_N $last)" 1 || die 'the tip was pushed with more than 1 N'
  below "$(most most_m_s $last)" .1 || die 'the tip was faster than 0.1 m/s'
  below 0.05 "$(most most_N $last)" || die 'the motors did nothing'
}
kill -TERM $builder
stop_board
