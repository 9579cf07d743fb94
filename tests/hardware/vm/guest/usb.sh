#!/bin/sh
# USB: a serial gadget (CDC ACM) and its host in one machine, /dev/ttyGS0 at the controller's end and /dev/ttyACM0 at the host's. The cable is
# pulled in an upload; then a day over SLCAN, and the same with slcand as a SocketCAN interface.
. /usr/local/bin/lib.sh

modprobe dummy_hcd
modprobe cdc-acm
modprobe libcomposite
modprobe usb_f_acm
gadget=/sys/kernel/config/usb_gadget/thimble
mkdir -p $gadget/strings/0x409 $gadget/configs/c.1 $gadget/functions/acm.0
echo 0x1d6b >$gadget/idVendor  # the Linux Foundation's
echo 0x0104 >$gadget/idProduct
echo Thimble >$gadget/strings/0x409/product
ln -s $gadget/functions/acm.0 $gadget/configs/c.1
plug_in() {
  basename /sys/class/udc/* >$gadget/UDC
  wait_until 10 test -c /dev/ttyACM0
}
pull_out() {
  echo '' >$gadget/UDC
  wait_until 10 test ! -e /dev/ttyACM0
}
plug_in

step 'the cable is pulled in an upload'
start_controller --tty /dev/ttyGS0
upload baboon.thim slcan:/dev/ttyACM0
pull_out
broke_off link-lost
fails 3 no-device thimble info --device slcan:/dev/ttyACM0
plug_in
goes_on baboon.thim slcan:/dev/ttyACM0

step 'the cable is pulled while nobody looks'
pull_out
sleep 2
plug_in
thimble info --device slcan:/dev/ttyACM0 >/dev/null || die 'after the cable was pulled'

step 'slcan'
session slcan:/dev/ttyACM0

step 'slcand'
stop_controller
start_controller --tty /dev/ttyGS0
modprobe slcan
slcand -o -s8 /dev/ttyACM0 slcan0
wait_until 10 ip link set slcan0 up
session can:slcan0
killall slcand
stop_controller
