#!/bin/sh
# Every way in which thimble-board can fail, and what its outputs do then.
. /usr/local/bin/lib.sh
. /usr/local/bin/board_lib.sh

load_devices
make_lines
mkdir /tmp/store
ip link add dev vcan0 type vcan
ip link set vcan0 mtu 72 up
device='--device can:vcan0'
start_arm

armed_board() {
  release_all
  thimble upload walls.thim $device >/dev/null 2>&1
  thimble home $device >/dev/null
  thimble arm $device >/dev/null
  wait_until 1 enabled
  no_voltage && die 'armed, and no current to carry the arm'
  true
}

step 'SIGKILL'
start_board
armed_board
kill -KILL $board
wait_until 1 not_enabled
wait_until 1 no_voltage
wait_until 1 guardian_gone

step 'the converter fails'
start_board
armed_board
echo 5 >/sys/module/arm_hardware/parameters/spi_error
wait_until 1 not_enabled
wait_until 1 fault_is drive_fault
fails 9 device-faulted thimble fault clear $device
echo 0 >/sys/module/arm_hardware/parameters/spi_error
sleep 0.1
no_voltage || die 'the converter kept its voltages'
thimble fault clear $device >/dev/null
thimble arm $device >/dev/null

step 'the drive says that it failed'
wait_until 1 enabled
pull 2 down
wait_until 1 fault_is drive_fault
not_enabled || die 'a faulty drive stayed on'
pull 2 up
stop_board

step 'the encoders stop'
start_board
armed_board
kill -STOP $arm
wait_until 1 fault_is encoder_stale
not_enabled || die 'without encoders the drive stayed on'
kill -CONT $arm
stop_board

# In the emulated time: one nanosecond an instruction.
# off_in_time WHAT: of the figure in /tmp/latency, 5 ms after the last outputs, which were up to a tick before the stop.
off_in_time() {
  figure "from $1 to 0 V: $(cat /tmp/latency)"
  [ "$(sed 's/.*"latency_us": \([0-9]*\).*/\1/' /tmp/latency)" -le 5500 ] || die 'later than 5 ms and the time of a tick'
  ! enable_line && no_voltage || die "$1, and the drive stayed on"
}
# found_off: the servo that resumes has latched a fault, and arms again once it is cleared.
found_off() {
  wait_until 1 thimble_answers
  fault_is 'drive_fault\|tick_lost' || die "no fault: $(thimble fault list $device)"
  sleep 0.2
  not_enabled || die 'the drive went on again'
  thimble fault clear $device >/dev/null
  thimble home $device >/dev/null  # its encoders have been stale
  thimble arm $device >/dev/null
  wait_until 1 enabled
}
thimble_answers() { thimble info $device >/dev/null 2>&1; }
step 'the board is stopped'
start_board
armed_board
stop_latency $board STOP >/tmp/latency || die "the currents went on: $(cat /tmp/latency)"
off_in_time SIGSTOP
sleep 1
not_enabled && no_voltage || die 'the drive went on again'
kill -CONT $board
found_off
stop_board

# Frozen with its guardian, as by `systemctl freeze`: no process is left to switch anything off.
step 'every process stands: the one-shot of the heartbeat switches the drive off'
mkdir /tmp/freezer
mount -t cgroup -o freezer freezer /tmp/freezer
mkdir /tmp/freezer/all
start_board
armed_board
for process in $board $(guardian); do echo $process >/tmp/freezer/all/cgroup.procs; done
echo FROZEN >/tmp/freezer/all/freezer.state
usleep 6000
enable_line || die 'a process still acted'
not_enabled || die 'the heartbeat goes on without a board'
echo THAWED >/tmp/freezer/all/freezer.state
found_off
stop_board

step 'lost_ticks asks for more than 5 ms'
start_board
refused 'lost_ticks_above_5_ms' thimble param set lost_ticks 5 $device
stop_board
# Saved by a board whose loop was faster.
sed 's/"rate_Hz": 1000/"rate_Hz": 2000/' board.json >faster.json
start_board faster.json
thimble param set lost_ticks 5 $device >/dev/null
thimble param save $device >/dev/null
stop_board
board_check 3 'lost_ticks 5 at 1000 Hz asks the stop path for 6 ms, allowed are 5 ms; lower lost_ticks'
start_board
release_all
thimble home $device >/dev/null
refused 'board_lacks(lost_ticks_above_5_ms)' thimble arm $device
thimble param set lost_ticks 4 $device >/dev/null
thimble param save $device >/dev/null
stop_board

for signal in KILL STOP; do
  step "the guardian gets SIG$signal: the board ends too"
  start_board
  armed_board
  kill -$signal "$(guardian)"
  status=0
  wait $board || status=$?
  [ $status = 1 ] && grep guardian /tmp/board.err || die "the board ended with $status: $(cat /tmp/board.err)"
  not_enabled && no_voltage || die 'the drive stayed on'
  guardian_gone || die 'the guardian is still there'
done

step 'a thread hangs: the watchdog bites'
mkdir /tmp/freezer/hung
for thread in thimble-servo thimble-link; do
  start_board
  armed_board
  dmesg -c >/dev/null
  sleep 1.5
  ! dmesg | grep softdog || die 'it bit a board that works'
  thread_of $thread >/tmp/freezer/hung/tasks
  if [ $thread = thimble-servo ]; then
    stop_latency /tmp/freezer/hung/freezer.state FROZEN >/tmp/latency || die "the currents went on: $(cat /tmp/latency)"
    off_in_time 'the freezing of the servo'
  fi
  echo FROZEN >/tmp/freezer/hung/freezer.state
  kill -STOP $arm  # its simulation is what takes long here
  sleep 11.5
  dmesg | grep 'softdog.*Reboot ignored' || die "$thread hangs and nothing bites"
  echo THAWED >/tmp/freezer/hung/freezer.state
  stop_board
  kill -CONT $arm
  not_enabled || die 'the drive stayed on'
done

step 'the orderly end: the watchdog is told'
dmesg -c >/dev/null
sleep 2
! dmesg | grep softdog || die 'it bites after the end'

step 'a user without privileges'
user='setpriv --reuid 65534 --regid 65534 --clear-groups'
chown -R 65534 /tmp/store
board_as=$user board_check 5 'Permission denied'
board_as=$user start_board
wait_until 5 fault_is e_stop  # it cannot read the line
fails 9 device-faulted thimble arm $device
for name in 'spidev0.0: Permission denied' 'counter0: Permission denied' '"ESTOP": Permission denied' rtprio memlock; do
  grep -q "$name" /tmp/board.err || die "it does not say $name: $(cat /tmp/board.err)"
done
stop_board
chown 65534 /dev/gpiochip* /dev/spidev* /dev/counter* /dev/watchdog
board_as=$user board_check 5 'rtprio'
board_as=$user start_board
release_all
thimble home $device >/dev/null
refused 'board_lacks.*no_locked_memory,no_realtime_priority' thimble arm $device
stop_board
