#!/bin/sh
# docs/examples/can_client.py, which uses other people's parts (python-can, the kernel's ISO-TP, canmatrix), with the controller.
. /usr/local/bin/lib.sh

tar -xf python.tar -C / || die 'python.tar'
rm python.tar
ip link add dev vcan0 type vcan
ip link set vcan0 up
# Once armed: onto the floor and 6 mm below it. Soon, because the arm's simulated time is slow under emulation.
printf 'time_s,x_m,y_m,z_m\n0,0,0,0\n0.3,0,0,-0.036\n' >/tmp/hand.csv
start_controller --can vcan0 --hand /tmp/hand.csv

thimble dbc --output /tmp/thimble.dbc
step 'the example client'
python3 can_client.py vcan0 walls.thim /tmp/thimble.dbc 8 >/tmp/client 2>/tmp/client.err || die "the client: $(cat /tmp/client /tmp/client.err)"
cat /tmp/client
grep -q '^arm 0: force [^ ]* [^ ]* [0-9]*\.[0-9]* N, contacts 1$' /tmp/client || die 'it felt no floor'
! grep -q ' 0\.000 N' /tmp/client || die 'it felt no force'
grep -qx disarmed /tmp/client || die 'it did not disarm'

thimble info --device can:vcan0 --json >/tmp/info
[ "$(field mode /tmp/info)" = ready ] || die "mode: $(field mode /tmp/info)"
grep -q '"walls"' /tmp/info || die "another scene runs: $(cat /tmp/info)"
stop_controller
