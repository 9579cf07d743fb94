#!/bin/sh
# Uploads through CAN interfaces that go down in the middle: the host says so, and a second upload goes on from there. On two of QEMU's
# kvaser_pci.
. /usr/local/bin/lib.sh

modprobe kvaser_pci
for can in can0 can1; do ip link set $can up type can bitrate 500000; done
start_controller --can can0

step 'the host'"'"'s interface goes down in an upload'
upload ring.thim can:can1
ip link set can1 down
broke_off interface-down
fails 6 interface-down thimble info --device can:can1
ip link set can1 up
goes_on ring.thim can:can1

step 'the controller'"'"'s interface goes down in an upload'
stop_controller
start_controller --can can0
upload ring.thim can:can1
ip link set can0 down
wait_until 10 grep -q 'can0 is down' /tmp/controller.err
broke_off no-answer
ip link set can0 up
wait_until 10 grep -q 'whole again' /tmp/controller.err
goes_on ring.thim can:can1
stop_controller
