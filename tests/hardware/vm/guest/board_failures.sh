#!/bin/sh
# Every way in which thimble-board can fail, and what its outputs do then.
. /usr/local/bin/lib.sh
. /usr/local/bin/board_lib.sh

modprobe -a gpio-sim arm_hardware
modprobe softdog soft_noboot=1
make_lines
mkdir /tmp/store
ip link add dev vcan0 type vcan
ip link set vcan0 mtu 72 up
device='--device can:vcan0'
sed 's#"realtime"#"watchdog": { "device": "/dev/watchdog", "timeout_s": 1 }, &#' board.json >/tmp/watched.json
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

step 'the guardian is ended: the board ends too'
start_board
armed_board
kill -KILL "$(guardian)"
status=0
wait $board || status=$?
[ $status = 1 ] && grep guardian /tmp/board.err || die "the board ended with $status: $(cat /tmp/board.err)"
not_enabled && no_voltage || die 'the drive stayed on'

centiseconds() { cut -d' ' -f1 /proc/uptime | tr -d .; }
step 'a thread hangs: the watchdog bites'
mkdir /tmp/freezer
mount -t cgroup -o freezer freezer /tmp/freezer
mkdir /tmp/freezer/hung
for thread in thimble-servo thimble-link; do
  start_board /tmp/watched.json
  armed_board
  dmesg -c >/dev/null
  sleep 1.5
  ! dmesg | grep softdog || die 'it bit a board that works'
  thread_of $thread >/tmp/freezer/hung/tasks
  echo FROZEN >/tmp/freezer/hung/freezer.state
  if [ $thread = thimble-servo ]; then
    frozen=$(centiseconds)
    until not_enabled || [ $(($(centiseconds) - frozen)) -gt 100 ]; do :; done
    figure "the drive went off $(($(centiseconds) - frozen)) cs after the servo had stopped"
    [ $(($(centiseconds) - frozen)) -le 20 ] || die 'the servo hangs and the drive stays on'
  fi
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
chown 65534 /dev/gpiochip* /dev/spidev* /dev/counter*
board_as=$user board_check 5 'rtprio'
board_as=$user start_board
release_all
thimble home $device >/dev/null
refused 'board_lacks.*no_locked_memory,no_realtime_priority' thimble arm $device
stop_board
