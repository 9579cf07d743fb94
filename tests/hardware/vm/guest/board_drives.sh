#!/bin/sh
# thimble-board with an arm of drives on CAN: emulated drives on a virtual bus with the simulated arm behind them. Its life, and what the arm
# does when the board is killed, stopped, or stopped with its guardian. First the five-bar of docs/examples/five-bar from its files, as its
# builder sets it up; then the Premium. $KIND: only drives of this kind, and all of it.
. /usr/local/bin/lib.sh
. /usr/local/bin/board_lib.sh

load_devices
make_lines
mkdir /tmp/store
for bus in vcan0 vcan1; do
  ip link add dev $bus type vcan
  ip link set $bus mtu 72 up
done
device='--device can:vcan0'

# drive KIND ID: of the configuration, with what all kinds have.
drive() {
  echo "{ \"can\": \"vcan1\", \"kind\": \"$1\", \"id\": $2, \"peak_torque_N_m\": 1, \"top_speed_rad_s\": 500,"
  mit="\"damping_N_m_s_rad\": 0.002, \"reply_id\": $(($2 + 16)), \"ranges\": { \"position_rad\": 12.5, \"velocity_rad_s\":"
  case $1 in
    moteus) echo '"watchdog_ms": 15, "damping_N_m_s_rad": 0.0005, "kd_N_m_s_turn": 0.25 }' ;;
    odrive_0.5) echo '"watchdog_ms": 15, "current_limit_A": 20, "torque_constant_N_m_A": 0.04, "estimates_ms": 1 }' ;;
    odrive_0.6) echo '"watchdog_ms": 15, "current_limit_A": 20, "estimates_ms": 1, "configuration": ['
      echo '{ "name": "axis0.config.enable_watchdog", "number": 100, "integer": true, "value": 1 },'
      echo '{ "name": "axis0.config.watchdog_timeout", "number": 101, "value": 0.015 } ] }' ;;
    damiao | damiao_fd) echo "\"watchdog_ms\": 15, $mit 30, \"torque_N_m\": 1 } }" ;;
    mini_cheetah) echo "\"watchdog_ms\": 25, \"watchdog_proven\": true, $mit 65, \"torque_N_m\": 1 } }" ;;
    cubemars) echo "\"watchdog_ms\": 25, \"watchdog_proven\": true, $mit 50, \"torque_N_m\": 1 } }" ;;
  esac
}
configure() {
  sed '/"encoders"/,/"enable"/d; /"drive_fault"/d; /"heartbeat"/d' board.json | sed "s/\"model\": .*/\"model\": \"premium-1.5\", \"drives\": [/" >/tmp/start
  sed -n '1,/"drives"/p' /tmp/start >drives.json
  for id in 1 2 3; do
    drive "$1" $id
    [ $id = 3 ] || echo ,
  done >>drives.json
  echo ']' >>drives.json
  sed '1,/"drives"/d' /tmp/start >>drives.json
}
# emulate ARM HAND DRIVE...: the simulated arm behind these drives, held by a hand. $arm_options: more.
emulate() {
  rm -f /tmp/drives
  emulated_arm=$1 hand=$2
  shift 2
  n=0 options=
  for one in "$@"; do
    options="$options --drive $one --inject 0:$n:watchdog_s=.015"
    n=$((n + 1))
  done
  thimble-sim-drive vcan1 --arm "$emulated_arm" --hand "$hand" --priority 90 $arm_options $options >/tmp/drives 2>&1 &
  drives=$!
  wait_until 20 grep -qx ready /tmp/drives
}
# emulated_of KIND ID: as thimble-sim-drive names it.
emulated_of() {
  case $1 in
    odrive_*) echo "odrive0${1#odrive_0.}:$2" ;;
    moteus) echo "moteus:$2" ;;
    *) echo "$(echo $1 | tr _ -):$2:$(($2 + 16)):1" ;;
  esac
}
start_drives() { emulate premium-1.5 hand.csv $(for id in 1 2 3; do emulated_of $1 $id; done); }
stop_drives() {
  kill -TERM $drives
  wait $drives || die "thimble-sim-drive ended with $?: $(cat /tmp/drives)"
}
reports() { grep -c off_after_ms /tmp/drives || true; }
more_reports() { [ "$(reports)" -gt "$before" ]; }
value() { tail -n 1 /tmp/drives | sed "s/.*\"$1\": \([0-9.]*\).*/\1/"; }
at_most() { awk "BEGIN { exit !($1 <= $2) }"; }

# In contact, so that the drives hold the hand off.
scene=walls.thim arm_options= own_arm=false
touching() {
  release_all
  sleep 0.5  # the hand has gone back to the start
  thimble upload $scene $device >/dev/null 2>&1
  wait_until 20 home
  if $own_arm; then  # that has not passed
    thimble param set allow_uncommissioned 0 $device
    refused arm_not_commissioned thimble arm $device
    thimble param set allow_uncommissioned 1 $device
  fi
  thimble arm $device >/dev/null
  (wait_until 10 touches 100) || die "no contact: $(thimble fault list $device; thimble monitor --count 2 $device; cat /tmp/board.err)"
  thimble info $device --json >/tmp/info
  [ "$(field mode /tmp/info)" = armed ] || die "not armed any more: $(thimble fault list $device; cat /tmp/board.err)"
  before=$(reports)
}
home() { thimble home $device; }

# went_off WHAT LIMIT_MS: within the limit after the last command; the tip travelled less than 1 mm until then, and is as slow as a hand after it.
went_off() {
  wait_until 5 more_reports
  figure "$kind, $1: $(tail -n 1 /tmp/drives)"
  at_most "$(value off_after_ms)" "$2" || die 'too late'
  at_most "$(value travel_till_off_mm)" 1 || die 'the tip went too far until then'
  at_most "$(value travel_mm)" 20 && at_most "$(value speed_m_s)" 0.5 || die 'the tip went too far or too fast'
}

killed() {
  step "$kind: SIGKILL"
  start_board drives.json
  touching
  kill -KILL $board
  went_off SIGKILL 7  # the kernel closes the pipe when it has taken the memory down
  wait_until 1 guardian_gone
}
stopped() {
  step "$kind: SIGSTOP, and what is found when it goes on"
  start_board drives.json
  touching
  kill -STOP $board
  went_off SIGSTOP 7
  kill -CONT $board
  wait_until 5 fault_is 'drive_fault\|tick_lost'
  sleep 1
  [ "$(reports)" = $((before + 1)) ] || die 'the drives went on again'
  wait_until 5 thimble fault clear $device
  stop_board
}

# The wall of wall.scene.json was felt: across it the arm pushed the hand with its stiffness times the depth of the tip, which the springs between
# motors and tip (tip_stiffness_N_m; at the wall 3.8e-5 m/N across it) make a little less, and along it with nothing. Across the wall 1 N m of a
# motor is 8.05 N, along it 13.8 N, so the friction of both motors (0.004 N m each) is up to 0.064 N and 0.11 N; a count (half of one at home, half
# at the wall) is up to 0.097 mm, 0.049 N.
wall_was_felt() {
  tail -n 1 /tmp/drives | tr -d '[],' | awk '{
    for (i = 1; i < NF; i++) { if ($i == "\"hand_N\":") { along = $(i + 1); across = -$(i + 2) } if ($i == "\"tip_mm\":") depth = $(i + 2) - 12 }
    expected = 500 * depth * 1e-3 / (1 + 500 * 3.8e-5)
    printf "figure: depth %.2f mm, felt %.3f N, by the scene %.3f N, along the wall %.3f N\n", depth, across, expected, along
    off = across - expected
    exit !(depth > 3 && off > -0.113 && off < 0.113 && along > -0.115 && along < 0.115)
  }' || die "the wall was not felt: $(tail -n 1 /tmp/drives)"
}

# five_bar KIND ID ID
five_bar() {
  kind="five-bar on $1"
  mkdir -p /tmp/five-bar
  rm -rf /tmp/five-bar/*
  sed 's/can\([01]\)/vcan\1/; s|/var/lib/thimble|/tmp/five-bar|' five-bar.json >drives.json
  [ $1 = odrive_0.5 ] || {  # the file has those
    mv drives.json /tmp/start
    { sed -n '1,/"drives"/p' /tmp/start; drive $1 $2; echo ,; drive $1 $3; sed '1,/"drives"/d' /tmp/start | sed -n '/^ *\]/,$p'; } >drives.json
  }
  printf '%s\n' time_s,x_m,y_m,z_m 0,0,0,0 0.3,0,0,0 0.7,0,0.02,0 >five-bar.csv
  thimble model compile five-bar-odrive.arm.json --output /tmp/arm.tarm

  step "$kind: the board has the arm once it is uploaded"
  board_check 3 'missing: the store does not have the arm "five-bar-odrive"; upload it: thimble model upload' drives.json
  arm_options='--step 100'  # its mechanics in finer steps would be most of what this machine does
  emulate /tmp/arm.tarm five-bar.csv $(emulated_of $1 $2) $(emulated_of $1 $3)
  start_board drives.json
  release_all
  refused no_stored_model thimble arm $device
  thimble model upload five-bar-odrive.arm.json $device
  thimble info $device | grep '^arm  ' | grep -q five-bar-odrive || die "the board has another arm: $(thimble info $device)"
  [ "$(cat /proc/$board/comm)" = thimble-board ] || die 'the board has another process'

  step "$kind: a wall is felt; then the board is killed and its guardian stopped, so that the drives' watchdogs act"
  scene=wall.scene.json own_arm=true
  touching
  sleep 4  # the hand comes to rest, against the damping of the drives too; what it felt is smoothed over 0.5 s
  stopped_guardian=$(guardian)
  kill -STOP $stopped_guardian
  kill -KILL $board
  went_off 'SIGKILL, and SIGSTOP of the guardian' $(($(watchdog_ms) + 2))
  wall_was_felt
  kill -CONT $stopped_guardian
  wait_until 2 guardian_gone
}
watchdog_ms() { sed -n 's/.*"watchdog_ms": \([0-9]*\).*/\1/p' drives.json | head -n 1; }

both_stopped() {
  step "$kind: the guardian stopped too, so that the drives' watchdogs act"
  start_board drives.json
  touching
  kill -STOP "$(guardian)" $board
  went_off 'SIGSTOP of both' $(($(watchdog_ms) + 2))
  kill -CONT $board "$(guardian)"  # the board has seen its guardian stopped, and may have ended for that
  sleep 0.5
  kill -KILL $board 2>/dev/null || true
  wait_until 2 guardian_gone
}

on_premium() {
  kind=$1
  configure $kind
  step "$kind: nobody answers, then everybody"
  board_check 3 "arm 0 joint 2 ($kind 2 on vcan1): does not answer; check its power" drives.json
  start_drives $kind
  board_check 0 'nothing is missing' drives.json
  grep -q "joint 3 ($kind 3 on vcan1): off, watchdog 15 ms" /tmp/check || die 'no word of the watchdog'
  killed
  stopped
}

case ${KIND-} in
  '')
    five_bar odrive_0.5 0 1
    stop_drives
    scene=walls.thim arm_options= own_arm=false
    on_premium moteus
    stop_drives
    ;;
  moteus | odrive_*)
    on_premium $KIND
    both_stopped
    stop_drives
    exit
    ;;
  *)  # Of some of them a bus carries two at this rate; and the codes of their torque are too coarse for the Premium's motors.
    five_bar $KIND 1 2
    killed
    stopped
    both_stopped
    stop_drives
    exit
    ;;
esac

step 'a life, orderly, and a drive that falls silent'
kind=moteus
configure moteus
start_drives moteus
start_board drives.json
touching
thimble disarm $device >/dev/null
went_off disarm 2.5
touching
kill -STOP $drives
wait_until 2 fault_is 'encoder_stale\|drive_fault'
kill -CONT $drives
stop_board
grep 'moteus . on vcan1): ' /tmp/board.err || die 'no word of the drive'
stop_drives
