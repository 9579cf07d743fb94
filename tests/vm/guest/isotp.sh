#!/bin/sh
# ISO-TP of ours against the kernel's, on a virtual CAN bus: isotp_peer does what $PEER says.
. /usr/local/bin/lib.sh

ip link add dev vcan0 type vcan
ip link set vcan0 up
# shellcheck disable=SC2086  # words
isotp_peer vcan0 $PEER
