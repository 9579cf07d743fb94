#!/bin/sh
# thimble-board on devices of the kernel: simulated counters and converter (arm_hardware), GPIO lines (gpio-sim), SocketCAN, and the
# simulated arm behind them. Its whole life, and every way in which it must let go.
. /usr/local/bin/lib.sh
. /usr/local/bin/board_lib.sh

load_devices
make_lines
mkdir /tmp/store
ip link add dev vcan0 type vcan
ip link set vcan0 mtu 72 up

step 'what --check says'
board_check 0 'nothing is missing'

step 'which devices the configuration names, for the udev rule'
chip_of() { gpiofind "$1" | cut -d' ' -f1; }
uses() { thimble-board --config "$1" --uses "/dev/$2"; }
sed '/"heartbeat"/d' board.json >/tmp/no_heartbeat.json
for node in "$(chip_of ESTOP)" "$(chip_of HEARTBEAT)" spidev0.0 counter0 watchdog; do
  uses board.json "$node" || die "$node is not named"
done
! uses /tmp/no_heartbeat.json "$(chip_of HEARTBEAT)" || die 'a chip without a named line is named'
uses /tmp/no_heartbeat.json "$(chip_of ESTOP)" || die 'the chip of the e-stop is not named'
for node in watchdog0 ttyS0 spidev0.1 gpiochip9; do ! uses board.json $node || die "$node is named"; done
for class in gpiochip spi counter watchdog; do
  grep -q " $class\$" /proc/devices || die "the unit allows char-$class, and the kernel has no such class"
done

step 'without a watchdog it does not arm'
sed 's#"watchdog": .*#"node": 1#' board.json >/tmp/unwatched.json
board_check 3 'no watchdog is configured; add' /tmp/unwatched.json
start_board /tmp/unwatched.json
release_all
refused 'board_lacks(no_watchdog)' thimble arm --device can:vcan0
stop_board
modprobe -r softdog
board_check 3 '/dev/watchdog: No such file'
modprobe softdog soft_noboot=1
modprobe -r arm_hardware
board_check 3 '/dev/spidev0.0: No such file'
grep -q 'counter "arm_hardware"' /tmp/check || die "no counter is not told: $(cat /tmp/check)"
modprobe arm_hardware

step 'a board with an open e-stop wire'
start_arm
start_board
device='--device can:vcan0'
thimble upload walls.thim $device >/dev/null
wait_until 5 fault_is e_stop  # nobody holds its line: an open wire is pressed
fails 9 device-faulted thimble arm $device
close_contacts
thimble fault clear $device >/dev/null

step 'home, arm, touch the wall'
thimble home $device >/dev/null
thimble arm $device >/dev/null
wait_until 1 enabled
wait_until 60 touches 100
thimble info $device --json >/tmp/info
figure "contact for $(field contact_ticks /tmp/info) ticks, most $(field peak_force_N /tmp/info) N, worst tick $(field worst_tick_s /tmp/info) s"

# The e-stop may be pressed just after a tick has read it: the next tick brakes, a period and the tick's own time later.
step 'the e-stop'
stop_latency $lines/sim_gpio0/pull pull-down >/tmp/latency || die "the currents went on: $(cat /tmp/latency)"
figure "from the e-stop's edge to other currents: $(cat /tmp/latency)"
[ "$(sed 's/.*"latency_us": \([0-9]*\).*/\1/' /tmp/latency)" -le 1200 ] || die 'later than one tick and its own time'
fault_is e_stop || die "no fault: $(thimble fault list $device)"
wait_until 2 not_enabled
fails 9 device-faulted thimble fault clear $device
close_contacts
thimble fault clear $device >/dev/null
thimble arm $device >/dev/null

step 'the dead-man switch'
wait_until 1 enabled
press dead_man
wait_until 2 not_enabled
refused 'dead_man_released' thimble arm $device
close_contacts
thimble arm $device >/dev/null
wait_until 1 enabled

step 'the orderly end'
stop_board
not_enabled || die 'the drive stayed on'
grep -q ' 0 lost, .* 0 page faults' /tmp/board.err || die 'the servo lost ticks or memory'
stop_arm
grep '"bad_frames": 0}' /tmp/arm || die "the converter did not understand: $(cat /tmp/arm)"
