#!/bin/sh
# The reference builds of board/linux/reference: thimble-board --check with each one's configuration in a machine with devices of the names
# that the build has. Only the processor of the servo is another: this machine has one.
. /usr/local/bin/lib.sh

# lines NAME...: of a simulated GPIO chip.
make_chip() {
  chip=/sys/kernel/config/gpio-sim/board
  mkdir -p $chip/bank0
  echo 16 >$chip/bank0/num_lines
  n=0
  for name in "$@"; do
    mkdir $chip/bank0/line$n
    echo "$name" >$chip/bank0/line$n/name
    n=$((n + 1))
  done
  echo 1 >$chip/live
}
remove_chip() {
  echo 0 >$chip/live
  rmdir $chip/bank0/line* $chip/bank0 $chip
}
check() {
  status=0
  thimble-board --config "$1" --check >/tmp/check 2>&1 || status=$?
  cat /tmp/check
  [ $status = "$2" ] || die "--check ended with $status"
}

mkdir -p /var/lib/thimble
modprobe gpio-sim
modprobe softdog soft_noboot=1
ip link add dev can0 type vcan
ip link set can0 mtu 16 up

step 'BeagleBone: counters, converter, link on CAN'
modprobe arm_hardware eqep=1
make_chip AMP_EN ESTOP DEAD_MAN AMP_FAULT ARM_INDEX
check beaglebone.json 0
grep -q 'nothing is missing' /tmp/check || die 'something is missing'
grep -q 'us .*converters, on the wire of SPI' /tmp/check || die 'no budget'
grep -q 'no PREEMPT_RT' /tmp/check || die 'no word of the kernel'
figure "budget, BeagleBone: $(grep 'in all' /tmp/check)"
for bad in 's/48304180/48304181/:counter "48304181.counter"' 's/spidev0.0/spidev1.0/:spidev1.0' 's/ARM_INDEX/NO_SUCH/:NO_SUCH'; do
  sed "${bad%:*}" beaglebone.json >/tmp/bad.json
  check /tmp/bad.json 3
  grep -q "missing: .*${bad##*:}" /tmp/check || die "no word of $bad"
done
remove_chip
modprobe -r arm_hardware

step 'Raspberry Pi: three moteus, link on USB'
modprobe dummy_hcd
modprobe g_serial
wait_until 10 test -c /dev/ttyGS0
make_chip GPIO17 GPIO22
check raspberry-pi.json 3
grep -q 'missing: processor 3' /tmp/check || die 'this machine has one processor'
sed 's/, "cpu": 3//' raspberry-pi.json >/tmp/pi.json
check /tmp/pi.json 3
grep -q 'it has no CAN FD' /tmp/check || die 'a classic bus'
ip link set can0 down
ip link set can0 mtu 72 up
check /tmp/pi.json 3
grep -q 'arm 0 joint 3 (moteus 3 on can0): does not answer' /tmp/check || die 'drives that are not there'
thimble-sim-drive can0 --drive moteus:1 --drive moteus:2 --drive moteus:3 --priority 90 \
  --inject 0:0:watchdog_s=.015 --inject 0:1:watchdog_s=.015 --inject 0:2:watchdog_s=.015 >/tmp/drives 2>&1 &
wait_until 20 grep -qx ready /tmp/drives
check /tmp/pi.json 0
grep -q 'three moteus with telemetry at 1 kHz need 71 % of can0' /tmp/check || die 'no load'
grep -q 'joint 1 (moteus 1 on can0): off, watchdog 15 ms read back, configuration as in the file' /tmp/check || die 'no watchdog'
figure "budget, Raspberry Pi: $(grep 'in all' /tmp/check)"
