#!/bin/sh
# Real drivers: QEMU's CAN controllers, two kvaser_pci (classic, 500 kbit/s) and two ports of a ctucan_pci (FD, 500k/2M), all on one bus.
# A day on each kind. What the emulation does not have: arbitration, errors on the wire, and so no controller that leaves the bus by itself
# (guest/bus.sh sends the error frame of that).
. /usr/local/bin/lib.sh

modprobe kvaser_pci
modprobe ctucanfd_pci

step 'what the doctor says, and that its remedies help'
sudo() { "$@"; }
fails 3 no-interface thimble doctor --device can:can9
fails 6 interface-down thimble doctor --device can:can0
for address in can:can0 canfd:can2; do
  for round in 1 2 3 4; do  # bring up, restart by itself, queue
    status=0
    thimble doctor --device $address --json >/tmp/doctor 2>/dev/null || status=$?
    remedies=$(field remedy /tmp/doctor | grep ^sudo || true)
    [ -n "$remedies" ] || break
    eval "$(echo "$remedies" | sed -n 1p)"
  done
  [ $status = 0 ] && [ -z "$remedies" ] || die "$address is not in order: $(cat /tmp/doctor)"
  grep '"cause": "[0-9.]* [kM]bit/s' /tmp/doctor
done
thimble doctor --device can:can0 | grep -qx 'ok       bit-rate can0: 500 kbit/s.*' || die "$(thimble doctor --device can:can0)"
thimble doctor --device canfd:can2 | grep -q 'FD data 2 Mbit/s$' || die "$(thimble doctor --device canfd:can2)"
fails 2 classic-interface thimble doctor --device canfd:can0
for can in can0 can1 can2 can3; do ip link set $can down; ip link set $can txqueuelen 10; done

for can in can0 can1; do ip link set $can up type can bitrate 500000; done
for can in can2 can3; do ip link set $can up type can bitrate 500000 dbitrate 2000000 fd on; done
for pair in can0:kvaser_pci can1:kvaser_pci can2:ctucanfd_pci can3:ctucanfd_pci; do
  driver=$(basename "$(readlink "/sys/class/net/${pair%:*}/device/driver")")
  [ "$driver" = "${pair#*:}" ] || die "${pair%:*} has the driver $driver"
done

step 'classic: kvaser_pci'
start_controller --can can0
session can:can1
stop_controller

step 'a recording that the bus cannot carry'
for can in can0 can1; do ip link set $can down; ip link set $can up type can bitrate 125000; done
start_controller --can can0
thimble upload walls.thim --device can:can1 >/dev/null 2>&1 || die 'upload at 125 kbit/s'
fails 1 refused thimble record /tmp/recording --scene walls.thim --seconds 1 --device can:can1
grep -q needs_can_fd_or_lower_rate /tmp/fails || die "$(cat /tmp/fails)"
stop_controller

step 'FD: ctucan_pci'
start_controller --can can2
session canfd:can3
session can:can1  # a classic host and an FD controller on one bus
stop_controller
