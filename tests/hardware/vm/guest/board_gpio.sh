#!/bin/sh
# The GPIO lines of board/linux by libgpiod, on two simulated chips.
. /usr/local/bin/lib.sh

modprobe gpio-sim
device=/sys/kernel/config/gpio-sim/lines
mkdir -p $device
for bank in A B; do
  mkdir $device/bank$bank
  echo 4 >$device/bank$bank/num_lines
  for n in 0 1 2 3; do
    mkdir $device/bank$bank/line$n
    echo $bank$n >$device/bank$bank/line$n/name
  done
done
echo 1 >$device/live
folder=/sys/devices/platform/$(cat $device/dev_name)
gpio_test "$folder/$(cat $device/bankA/chip_name)" "$folder/$(cat $device/bankB/chip_name)"
