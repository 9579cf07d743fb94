#!/bin/sh
# thimble-board's other ways to read encoders, by sysfs and by GPIO edges, and what the servo asks of the kernel in its loop.
. /usr/local/bin/lib.sh
. /usr/local/bin/board_lib.sh

load_devices
make_lines 1A 1B 2A 2B 3A 3B INDEX AMP_EN_2
mkdir /tmp/store
ip link add dev vcan0 type vcan
ip link set vcan0 mtu 72 up
device='--device can:vcan0'

# calls THREAD FILE: the system calls of one thread in the output of strace, the most frequent first.
calls() { sed -n "s/^$1 *\([a-z0-9_]*\)(.*/\1/p" "$2" | sort | uniq -c | sort -rn; }

step 'what the servo asks of the kernel, counts by sysfs'
sed 's/"counter_events"/"counter"/; /"event"/d' board.json >/tmp/poll.json
start_arm
start_board /tmp/poll.json
release_all
thimble upload walls.thim $device >/dev/null 2>&1
thimble home $device >/dev/null
thimble arm $device >/dev/null
wait_until 60 touches 100
thread=$(thread_of thimble-servo)
strace -f -o /tmp/trace -p $board 2>/dev/null &
tracer=$!
sleep 0.5
kill $tracer
wait $tracer || true
calls $thread /tmp/trace >/tmp/calls
cat /tmp/calls
[ "$(awk '{print $2}' /tmp/calls | sort | tr '\n' ' ')" = 'clock_nanosleep ioctl pread64 read ' ] || die 'the servo asks for more'
[ "$(awk '$2 == "clock_nanosleep" {print $1}' /tmp/calls)" -gt 20 ] || die 'strace saw too little'
thimble disarm $device >/dev/null
stop_board
stop_arm
grep '"bad_frames": 0}' /tmp/arm

step 'encoders by GPIO edges'
cat >/tmp/joints <<'EOF'
{ "line_a": "1A", "line_b": "1B" }, { "line_a": "2A", "line_b": "2B" }, { "line_a": "3A", "line_b": "3B" }
EOF
tr -d '\n' <board.json | sed "s#\"encoders\": {[^]]*\]#\"encoders\": { \"read\": \"gpio\", \"joints\": [ $(cat /tmp/joints) ]#" >/tmp/gpio.json
start_board /tmp/gpio.json
release_all
thimble home $device >/dev/null
# turn LINE_A CYCLES: forwards, four counts a cycle, an edge in 2 ms.
turn() {
  n=0
  while [ $n -lt "$2" ]; do
    for edge in "$1 up" "$(($1 + 1)) up" "$1 down" "$(($1 + 1)) down"; do
      pull $edge
      usleep 2000
    done
    n=$((n + 1))
  done
}
x_um() { thimble monitor --count 1 $device | awk '$1 == "0" {printf "%d", $2 * 1e6}'; }
before=$(x_um)
turn 4 50  # joint 1, 200 counts of 24.8 um at the tip
sleep 0.1
after=$(x_um)
figure "200 counts of joint 1 moved the tip from $before um to $after um in x"
moved=$((after - before))
[ ${moved#-} -ge 4900 ] && [ ${moved#-} -le 5020 ] || die "moved by $moved um"
! fault_is encoder || die 'a fault without a lost edge'

# More edges than the kernel keeps between two ticks, here by a servo that is held up.
step 'edges that are too many are lost, and that is a fault'
mkdir /tmp/freezer
mount -t cgroup -o freezer freezer /tmp/freezer
mkdir /tmp/freezer/held
thread_of thimble-servo >/tmp/freezer/held/tasks
echo FROZEN >/tmp/freezer/held/freezer.state
turn 4 10
echo THAWED >/tmp/freezer/held/freezer.state
wait_until 2 fault_is encoder_stale
sleep 0.3
thimble fault clear $device >/dev/null
thimble home $device >/dev/null
stop_board

step 'two arms, and an index that one of them has to see'
# The second arm has lines of its own, also for its encoders, and a converter of its own.
tr -d '\n' </tmp/poll.json | sed 's#"arms": \[ *\(.*\) *\], *"e_stop"#"arms": [\1, \1], "e_stop"#; s#"AMP_EN"#"AMP_EN_2"#2; s#spidev0.0#spidev0.1#2
  s#"drive_fault"#"index": { "line": "INDEX", "active": "high" }, "drive_fault"#2' |
  sed "s#\"encoders\": {[^]]*\]#\"encoders\": { \"read\": \"gpio\", \"joints\": [ $(cat /tmp/joints) ]#2" >/tmp/two.json
start_arm
start_board /tmp/two.json
release_all
thimble home $device >/tmp/home 2>&1 &
homing=$!
sleep 0.5
kill -0 $homing || die "it was homed without its index: $(cat /tmp/home)"
thimble info $device --json >/tmp/info
[ "$(field mode /tmp/info)" = homing ] || die "no index, and yet: $(cat /tmp/info)"
pull 10 up
pull 10 down
wait $homing || die "home: $(cat /tmp/home)"
thimble arm $device >/dev/null
wait_until 2 enabled
[ "$(cat "$lines/sim_gpio11/value")" = 1 ] || die 'the second arm is not enabled'
thimble disarm $device >/dev/null
wait_until 2 not_enabled
[ "$(cat "$lines/sim_gpio11/value")" = 0 ] || die 'the second arm stays enabled'
stop_board
stop_arm
