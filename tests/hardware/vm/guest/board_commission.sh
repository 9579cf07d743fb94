#!/bin/sh
# The five-bar of docs/examples/five-bar, from its files to a wall that is felt, as its builder goes: the board gets the arm, `thimble commission`
# proves it over the link, and names the motor that is wired backwards. The builder (builder_rig.h) does what the tool prints. Then the board gets
# a scene, and after step 10 the arm as it was measured before. $UNTIL: the last step. What of it has been seen: docs/commissioning.md.
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
# commission [OPTION]...: into /tmp/commissioned; the builder reads what it prints. A tick that this machine loses ends a recording, and the tool
# says so: the same command goes on with the same step.
commission() {
  for run in 1 2 3 4 5; do
    builder_lives
    status=0
    thimble commission $arm $device "$@" >/tmp/commissioned 2>/tmp/prompts </tmp/answers || status=$?
    sleep 0.2  # the builder reads the rest
    tail -n 2 /tmp/built | grep -q '^thimble: counts-missing' || break
  done
  builder_lives
}
# What the board keeps of a fault, too: it may be why a step has ended.
tell_all() {
  thimble fault list $device --json >/tmp/faults 2>&1 || true
  kill $board
  wait $board || true
  die "$1: $(tail -n 20 /tmp/built; cat /tmp/faults /tmp/board.err)"
}
# most NAME STEP: the most that the motors did before this step: most_N or most_m_s.
most() { sed -n "s/^before step $2: .*\"$1\": \([0-9.]*\).*/\1/p" /tmp/built | tail -n 1; }
below() { awk "BEGIN { exit !($1 < $2) }"; }

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
  [ $status = 0 ] || tell_all "the commissioning ended with $status"
  cat /tmp/commissioned
else
  for number in $(seq 0 $until); do
    commission --step $number
    [ $status = 0 ] || tell_all "step $number ended with $status"
  done
fi

step 'what the builder was told, and what the arm did'
first=$(grep -n '^  ! ' /tmp/built | head -n 1)
echo "$first"
echo "$first" | grep -q "  ! motor-sign: 'first': the motor turns backwards" || die 'another fault was named first'
[ "$(grep -c '^  ! ' /tmp/built)" = 1 ] || die 'more was named than what is wrong'
[ "$(grep '^  ! \|^step ' /tmp/built | grep -B 1 '^  ! ' | head -n 1 | cut -c1-6)" = 'step 5' ] || die 'not in step 5'
[ "$(grep -c '<the builder repairs' /tmp/built)" = 1 ] || die 'the builder has not repaired it'
! grep 'does not measure its current' /tmp/built || die 'an ODrive tells its current'
[ $until -lt 6 ] || {
  last=7
  [ $until -gt 6 ] || last=6
  figure "before step $last the tip was pushed with at most $(most most_N $last) N, and at most $(most most_m_s $last) m/s fast"
  below "$(most most_N $last)" 1 || die 'the tip was pushed with more than 1 N'
  below "$(most most_m_s $last)" .1 || die 'the tip was faster than 0.1 m/s'
  below 0.05 "$(most most_N $last)" || die 'the motors did nothing'
}

# The wall of wall.scene.json is felt across the table, with its stiffness times the depth of the tip; along it nothing is. The springs between
# motors and tip make that a little less, as in board_drives.sh. What may be off: friction of both motors, 15 % more than in the file (0.074 N and
# 0.127 N), a count (0.049 N), torque constants, which this arm without weight cannot show and are off by 3 % at most (0.06 N of 2 N), and the
# place of home, where the hand holds the arm within 0.3 degrees (0.5 % of the way to the wall: 0.03 N).
wall_was_felt() {
  grep '^{"way_mm"' /tmp/built | tail -n 1 | tr -d '[],{}' | awk '{
    depth = $2 - 12; along = $4; across = -$5
    expected = 500 * depth * 1e-3 / (1 + 500 * 3.8e-5)
    printf "figure: depth %.2f mm, felt %.3f N, by the scene %.3f N, along the wall %.3f N\n", depth, across, expected, along
    off = across - expected
    exit !(depth > 3 && off > -0.213 && off < 0.213 && along > -0.2 && along < 0.2)
  }' || tell_all "the wall was not felt: $(grep '^{"way_mm"' /tmp/built)"
}
# tell TEXT: somebody asks the builder for it; returns when it is done.
tell() {
  printf '  > %s\n    [] ' "$1" >/tmp/prompts
  timeout 30 head -n 1 /tmp/answers >/dev/null || die "the builder has not done it: $1"
}

if [ $until -ge 7 ]; then
  step 'a scene'
  [ $until -lt 10 ] || {
    thimble model upload /tmp/mine/five-bar-odrive.commissioned.arm.json $device
    release_all
  }
  # An arm that has not passed every step gets no more than 1 N.
  if [ $until -lt 10 ]; then thimble param set allow_uncommissioned 1 $device; fi
  thimble upload wall.scene.json $device >/dev/null
  thimble param set max_force 8 $device
  tell "Bring the arm to 'first' 139.0758 degrees, 'second' 40.9242 degrees, and hold it there."
  wait_until 20 thimble home $device
  thimble arm $device
  tell 'Push the tip away from you until you feel a wall, press it with 2 N, and hold.'
  thimble info $device --json >/tmp/info
  [ "$(field mode /tmp/info)" = armed ] || tell_all 'not armed any more'
  thimble disarm $device
  wall_was_felt
fi
kill -TERM $builder
wait $builder || die "the builder ended with $?"
tail -n 1 /tmp/built
stop_board
