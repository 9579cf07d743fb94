#!/bin/sh
# The board is stopped: the watchdog restarts the machine, and the board says so after the restart. This script runs in both starts.
. /usr/local/bin/lib.sh
. /usr/local/bin/board_lib.sh

modprobe -a gpio-sim arm_hardware i6300esb
make_lines
mkdir /tmp/store
ip link add dev vcan0 type vcan
ip link set vcan0 mtu 72 up
start_board
thimble info --device can:vcan0 --json >/tmp/info
reason=$(field reset_reason /tmp/info)

if [ -e /out/stopped ]; then
  step 'after the restart'
  rm /out/stopped
  figure "the reset reason: $reason"
  [ "$reason" = watchdog ] || die 'it does not say that the watchdog restarted the machine'
  stop_board
else
  step 'the board is stopped'
  [ -z "$reason" ] || die "a cold start has the reset reason $reason"
  touch /out/stopped
  sync
  kill -STOP $board
  sleep 20
  rm /out/stopped
  die 'the board is stopped and the machine goes on'
fi
