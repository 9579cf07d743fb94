#!/bin/sh
# A day with the controller on a virtual CAN bus, with classic frames and with FD frames, and a tester made of can-utils. The classic day's
# frames go to /out/session.log.
. /usr/local/bin/lib.sh

# record FILE: every frame on the bus, until end_record. The buffer holds what candump has no time for; -d tells if it did not.
record() {
  candump -L -d -r 8000000 vcan0 >"/tmp/$1" &
  dump=$! dumped=$1
  wait_until 10 grep -q '^ *vcan0 ' /proc/net/can/rcvlist_all  # it listens
}
end_record() {
  cansend vcan0 7FF#  # of nobody; when it is in the file, so is all before it
  wait_until 30 grep -q ' 7FF#' "/tmp/$dumped"
  kill $dump
  wait $dump || true
  ! grep DROPCOUNT "/tmp/$dumped" || die 'candump lost frames'
  sed -i '/ 7FF#/d' "/tmp/$dumped"
}

ip link add dev vcan0 type vcan
ip link set vcan0 up
start_controller --can vcan0

step 'a day with classic frames'
record session.log
session can:vcan0
end_record
[ "$(grep -c '##' /tmp/session.log)" = 0 ] || die 'there were FD frames'
cp /tmp/session.log /out

step 'a day with FD frames'
record fd.log
session canfd:vcan0
end_record
requests='18DA01F[2-9A-D]##' answers='18DAF[2-9A-D]01##'  # of hosts that claimed an address
figure "$(grep -c "$requests" /tmp/fd.log) FD frames of requests, $(grep -c "$answers" /tmp/fd.log) of answers"
[ "$(grep -c "$requests" /tmp/fd.log)" -gt 200 ] || die 'the upload had no FD frames'
[ "$(grep -c "$answers" /tmp/fd.log)" -gt 20 ] || die 'the answers were no FD frames'
[ "$(grep -o "$requests" /tmp/fd.log | sort -u | wc -l)" -gt 5 ] || die 'the commands had the same address'

step 'forces that a host orders'
thimble param set link_timeout 60 --device can:vcan0 >/dev/null  # a command takes long under emulation
thimble param set host_forces 1 --device can:vcan0 >/dev/null
[ "$(thimble arm --device can:vcan0)" = armed ] || die 'arming for a host that renders'
for number in 01 02 03; do cansend vcan0 "101#00${number}000000006400"; done
cansend vcan0 101#0000  # too short
cansend vcan0 102#0004000000006400  # of another node
thimble info --device can:vcan0 --json >/tmp/info
[ "$(field taken /tmp/info) $(field old /tmp/info) $(field wrong /tmp/info)" = '3 0 1' ] || die "orders: $(cat /tmp/info)"
[ "$(thimble disarm --device can:vcan0)" = ready ] || die 'disarming'
thimble param set host_forces 0 --device can:vcan0 >/dev/null

step 'a tester made of can-utils'
isotprecv -s 18DA01F1 -d 18DAF101 -p CC vcan0 >/tmp/answer &
receiver=$!
wait_until 10 grep -q 98daf101 /proc/net/can/rcvlist_eff
echo 22 F1 A0 | isotpsend -s 18DA01F1 -d 18DAF101 -p CC vcan0
wait $receiver
grep -qi '^62 F1 A0 .* 40 01 01' /tmp/answer || die "LinkInfo: $(cat /tmp/answer)"  # 64 bytes, node 1, 1 arm
isotprecv -s 18DA01F1 -d 18DAF101 -p CC vcan0 >/tmp/answer &
receiver=$!
wait_until 10 grep -q 98daf101 /proc/net/can/rcvlist_eff
echo 22 F1 A1 F1 A0 F1 95 | isotpsend -s 18DA01F1 -d 18DAF101 -p CC vcan0
wait $receiver
grep -qi '^62 F1 A1 .* F1 A0 .* F1 95 ' /tmp/answer || die "several records: $(cat /tmp/answer)"  # more than a frame: with flow control

stop_controller
