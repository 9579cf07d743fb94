#!/bin/sh
# ISO-TP of ours against the kernel's, on a virtual CAN bus: isotp_peer does what $PEER says, one after the other where it has a comma.
. /usr/local/bin/lib.sh

ip link add dev vcan0 type vcan
ip link set vcan0 up
IFS=,
for what in $PEER; do
  IFS=' '
  # shellcheck disable=SC2086  # words
  isotp_peer vcan0 $what
done
