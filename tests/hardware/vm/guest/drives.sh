#!/bin/sh
# Motor drives on a virtual CAN: the driver on a raw socket, with the kernel's filters and receive stamps, and emulated drives.
. /usr/local/bin/lib.sh

step 'no such interface, and one without FD'
! drive_session vcan0 moteus:1 >/tmp/said || die 'a bus that does not exist'
grep -q 'cannot use vcan0 for drives: No such device' /tmp/said || die "$(cat /tmp/said)"
ip link add dev vcan0 type vcan
ip link set vcan0 mtu 16 up
! drive_session vcan0 moteus:1 >/tmp/said || die 'a bus without FD'
grep -q 'it has no CAN FD' /tmp/said || die "$(cat /tmp/said)"
ip link set vcan0 down
ip link set vcan0 mtu 72 up

# run FAULT_OF_THE_FIRST NAME_OF_IT DRIVE...: from power-on to the fault.
run() {
  inject=$1 fault=$2
  shift 2
  arguments=
  for drive in "$@"; do arguments="$arguments --drive $(echo "$drive" | sed 's/_/-/')"; done
  rm -f /tmp/drives
  thimble-sim-drive vcan0 $arguments --inject "$inject" --inject 0:0:watchdog_s=.015 >/tmp/drives 2>&1 &
  drives=$!
  wait_until 20 grep -qx ready /tmp/drives
  status=0
  drive_session vcan0 "$@" >/tmp/said 2>&1 || status=$?
  cat /tmp/said
  [ $status = 0 ] || die "$* ended with $status"
  tail -n 1 /tmp/said | grep -q "/$fault" || die "$*: no fault $fault"
  figure "$*: $(grep 'running for' /tmp/said)"
  kill -TERM $drives
  wait $drives || die "thimble-sim-drive ended with $?"
}

step 'FD: moteus and Damiao'
run 2.5:0:mute silent moteus:1 damiao_fd:2
step 'classic'
run 2.5:0:fail=8 drive_reported damiao:1 mini_cheetah:2 odrive05:3
run 2.5:0:mute silent odrive06:1 cubemars:2
step 'an interface that goes down'
rm /tmp/drives /tmp/said  # or those of the run before would be read
thimble-sim-drive vcan0 --drive moteus:1 --inject 0:0:watchdog_s=.015 >/tmp/drives 2>&1 &
wait_until 20 grep -qx ready /tmp/drives
drive_session vcan0 moteus:1 >/tmp/said 2>&1 &
session=$!
wait_until 60 grep -q 'running for' /tmp/said
ip link set vcan0 down
wait $session || die "$(cat /tmp/said)"
tail -n 1 /tmp/said | grep -q /bus_off || die "$(cat /tmp/said)"
