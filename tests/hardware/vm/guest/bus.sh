#!/bin/sh
# What can happen on a CAN bus: an interface that is missing, down, too small, full, bus off or unplugged, two hosts at once, and a stop from
# another node.
. /usr/local/bin/lib.sh

ip link add dev vcan0 type vcan
fails 6 interface-down thimble info --device can:vcan0
fails 6 interface-down thimble doctor --device vcan0
fails 3 no-interface thimble info --device can:vcan1
fails 3 no-interface thimble info --device can:lo
ip link set vcan0 mtu 16
fails 2 classic-interface thimble info --device canfd:vcan0
ip link set vcan0 mtu 72 up
fails 6 no-answer thimble info --device can:vcan0

step 'what is listed'
thimble list >/tmp/list
grep -q '^vcan0  can' /tmp/list || die "thimble list: $(cat /tmp/list)"
fails 3 no-device thimble info  # nobody asks on a bus unless told to

start_controller --can vcan0
thimble info --device vcan0 >/dev/null || die 'by the name of the list'

step 'two hosts at once'
thimble monitor --seconds 60 --json --device can:vcan0 >/tmp/other &
other=$!
thimble upload blocks.thim --device canfd:vcan0 --json >/tmp/first 2>&1 &
first=$!
status=0
thimble upload ice.thim --device can:vcan0 --json >/tmp/second 2>&1 || status=$?
both="$status"
status=0
wait $first || status=$?
both="$both $status"
for host in first second; do  # each is done and verified, or was told why not
  [ "$(field verified /tmp/$host)" = true ] || grep -q '"remedy"' /tmp/$host || die "the $host of two hosts: $(cat /tmp/$host)"
done
figure "two uploads at once ended with $both"
thimble upload blocks.thim --device canfd:vcan0 --json >/tmp/first || die "an upload after two at once: $(cat /tmp/first)"
for i in 1 2 3 4 5; do
  thimble info --device can:vcan0 >/tmp/one &
  one=$!
  thimble info --device canfd:vcan0 >/tmp/two || die 'the second of two hosts'
  wait $one || die 'the first of two hosts'
done
wait_until 30 sh -c '[ "$(grep -c Pose /tmp/other)" -gt 10 ]'  # the host that only watches
kill -INT $other
wait $other || true

step 'the stop of any node on the bus'
cansend vcan0 001#00
wait_until 10 sh -c 'thimble fault list --device can:vcan0 | grep -q host_stop'
thimble fault clear --device can:vcan0 >/dev/null

step 'a slow bus with a short queue'
modprobe sch_tbf
tc qdisc add dev vcan0 root tbf rate 500kbit burst 32 limit 48  # three frames: no room most of the time, ENOBUFS
thimble upload asteroid.thim --device can:vcan0 --json >/tmp/uploaded || die "a full queue is no failure: $(cat /tmp/uploaded)"
figure "upload at 500 kbit/s: $(field rate_bytes_s /tmp/uploaded) B/s, $(field retried_blocks /tmp/uploaded) blocks twice"
tc -s qdisc show dev vcan0 >/tmp/queue
figure "the queue: $(grep -o 'dropped [0-9]*' /tmp/queue)"
[ "$(sed -n 's/.*dropped \([0-9]*\).*/\1/p' /tmp/queue)" -gt 100 ] || die "the queue was never full: $(cat /tmp/queue)"

step 'a bus that takes nothing'
tc qdisc replace dev vcan0 root tbf rate 8bit burst 20 limit 20
fails 6 bus-full thimble upload asteroid.thim --device can:vcan0
wait_until 10 grep -q 'vcan0 sends nothing' /tmp/controller.err
tc qdisc del dev vcan0 root
wait_until 10 sh -c 'tail -n 1 /tmp/controller.err | grep -q "whole again"'
thimble info --device can:vcan0 >/dev/null || die 'after the bus was full'

step 'bus off'
thimble monitor --seconds 60 --device can:vcan0 >/tmp/monitored 2>/tmp/monitor.err &
monitor=$!
wait_until 30 grep -q '^0 ' /tmp/monitored
# The error frame that a driver sends then (no emulated controller leaves the bus by itself), and in the same moment a host's request, which
# must not hide it from the controller.
echo '(0.000000) vcan0 20000040#0000000000000000
(0.000000) vcan0 18DA01F1#023E800000000000' | canplayer vcan0=vcan0
status=0
wait $monitor || status=$?
cat /tmp/monitor.err
[ $status = 6 ] && grep -q 'bus-off: .* bus off' /tmp/monitor.err || die "monitor ended with $status"
wait_until 10 grep -q 'vcan0 is bus off' /tmp/controller.err
cansend vcan0 20000100#0000000000000000  # and after the restart
wait_until 10 sh -c 'tail -n 1 /tmp/controller.err | grep -q "whole again"'
thimble info --device can:vcan0 >/dev/null || die 'after the restart'

step 'the interface goes, and comes back'
ip link del vcan0
wait_until 10 grep -q 'vcan0 is gone' /tmp/controller.err
fails 3 no-interface thimble info --device can:vcan0
ip link add dev vcan0 type vcan
ip link set vcan0 up
wait_until 10 thimble info --device can:vcan0
stop_controller
