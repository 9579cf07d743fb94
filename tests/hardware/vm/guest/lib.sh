# What the guest's scripts share. Sourced.
set -eu
cd /usr/local/bin  # where run-vm.sh puts the files

step() { echo "== $* [$(cut -d' ' -f1 /proc/uptime) s]"; }
die() { echo "FAILED: $*"; exit 1; }
figure() { echo "figure: $*"; }

# wait_until SECONDS COMMAND...: until the command succeeds.
wait_until() {
  tenths=$(($1 * 10))
  shift
  until "$@" >/dev/null 2>&1; do
    [ $((tenths -= 1)) -gt 0 ] || die "not in time: $*"
    sleep 0.1
  done
}

# The controller under test. Its command line is here and nowhere else.
# start_controller --can INTERFACE | --tty DEVICE
start_controller() {
  rm -f /tmp/controller  # or the one before would be ready
  case $CONTROLLER in
    thimble-sim) thimble-sim --no-pty --rate 1000 --store /tmp/scenes "$@" >/tmp/controller 2>/tmp/controller.err & ;;  # 1 kHz: under emulation
    thimble-board)
      [ -e /sys/class/net/workshop ] || make_board
      start_arm
      sed "s|\"links\": .*|\"links\": [{ \"$(echo "$1" | sed 's/--tty/slcan/; s/--can/can/')\": \"$2\" }, { \"can\": \"workshop\" }],|" board.json >/tmp/board.json
      thimble-board --config /tmp/board.json >/tmp/controller 2>/tmp/controller.err &
      ;;
    *) die "no controller is named $CONTROLLER" ;;
  esac
  controller=$!
  wait_until 20 grep -qx ready /tmp/controller
  [ $CONTROLLER = thimble-sim ] || release_all can:workshop
  fresh=1
}

# Its devices, the simulated arm behind them, and a bus of its own on which its first fault is cleared: that of an e-stop that nobody has closed yet.
make_board() {
  . board_lib.sh
  load_devices
  make_lines
  mkdir -p /tmp/store
  ip link add dev workshop type vcan
  ip link set workshop up
}

# Ends it as a user would, and by then it must not have died of anything else.
stop_controller() {
  kill -TERM "$controller" || die "the controller ended by itself: $(cat /tmp/controller.err)"
  wait "$controller" || die "the controller ended with $?: $(cat /tmp/controller.err)"
  [ $CONTROLLER = thimble-sim ] || stop_arm
  rm -rf /tmp/scenes /tmp/store/*
}

# fails CODE NAME COMMAND...: thimble ends with this exit code and names this error.
fails() {
  code=$1 name=$2
  shift 2
  status=0
  "$@" >/tmp/fails 2>&1 || status=$?
  [ "$status" = "$code" ] || die "$* ended with $status, not $code: $(cat /tmp/fails)"
  grep -q "^thimble: $name: " /tmp/fails || die "$* did not say $name: $(cat /tmp/fails)"
  grep "^thimble: \|^  remedy: " /tmp/fails
}

# field NAME FILE: the value of a JSON field, as thimble prints it, one a line.
field() { sed -n "s/^ *\"$1\": \"\{0,1\}\([^\",]*\)\"\{0,1\},\{0,1\}$/\1/p" "$2"; }

# The hand goes down to the floor, and somebody presses the e-stop: within a tick and its own time the currents change. Over this address; the
# arm is where it was put together.
touch_and_trip() {
  thimble upload walls.thim --device "$1" >/dev/null 2>&1 || die "upload of the walls over $1"
  thimble home --device "$1" >/dev/null
  thimble arm --device "$1" >/dev/null
  wait_until 60 touches 100 "$1"
  stop_latency $lines/sim_gpio0/pull pull-down >/tmp/latency || die "the currents went on: $(cat /tmp/latency)"
  figure "over $1, from the e-stop's edge to other currents: $(cat /tmp/latency)"
  [ "$(sed 's/.*"latency_us": \([0-9]*\).*/\1/' /tmp/latency)" -le 1200 ] || die 'later than one tick and its own time'
  wait_until 2 not_enabled
  fault_is e_stop "$1" || die "no fault over $1"
  fails 9 device-faulted thimble fault clear --device "$1"
  close_contacts
  thimble fault clear --device "$1" >/dev/null || die "clear over $1"
}

# What every user does in a day, over this address.
session() {
  if [ $CONTROLLER != thimble-sim ] && [ $fresh = 1 ]; then touch_and_trip "$1"; fi
  fresh=0
  thimble upload asteroid.thim --device "$1" --json >/tmp/uploaded || die "upload over $1"
  [ "$(field verified /tmp/uploaded)" = true ] || die "upload over $1: $(cat /tmp/uploaded)"
  figure "upload over $1: $(field bytes /tmp/uploaded) bytes at $(field rate_bytes_s /tmp/uploaded) B/s, $(field retried_blocks /tmp/uploaded) blocks twice"
  [ "$(thimble home --device "$1")" = ready ] || die "home over $1"
  [ "$(thimble arm --device "$1")" = armed ] || die "arm over $1"
  thimble monitor --count 20 --device "$1" >/tmp/monitored || die "monitor over $1"
  [ "$(grep -c 'armed$' /tmp/monitored)" -ge 1 ] || die "monitor over $1 shows no armed arm: $(cat /tmp/monitored)"
  thimble info --device "$1" --json >/tmp/info
  [ "$(field mode /tmp/info)" = armed ] || die "info over $1: $(cat /tmp/info)"
  [ "$(field scene_crc /tmp/info)" = "$(field crc /tmp/uploaded)" ] || die "another scene runs: $(cat /tmp/info)"
  thimble param set max_force 3.5 --device "$1" >/dev/null
  [ "$(thimble param get max_force --device "$1")" = 3.5 ] || die "parameter over $1"
  [ "$(thimble disarm --device "$1")" = ready ] || die "disarm over $1"
}

# upload IMAGE ADDRESS: begins one in the background, and returns once a tenth of it is there. Long enough to be interrupted.
upload() {
  rm -f /tmp/upload  # or the one before would be far enough
  thimble upload "$1" --device "$2" >/tmp/upload 2>&1 &
  uploading=$!
  wait_until 60 grep -q '^[1-9]0 %' /tmp/upload
}

# broke_off NAME: it ended with link lost, and said this.
broke_off() {
  status=0
  wait $uploading || status=$?
  grep '^thimble: \|^  remedy: ' /tmp/upload || true
  [ $status = 6 ] || die "the upload ended with $status: $(cat /tmp/upload)"
  grep -q "^thimble: $1: " /tmp/upload || die "the upload did not say $1: $(cat /tmp/upload)"
}

# goes_on IMAGE ADDRESS: the same upload once more does not begin at the beginning.
goes_on() {
  thimble upload "$1" --device "$2" --json >/tmp/uploaded || die "the second upload: $(cat /tmp/uploaded)"
  [ "$(field verified /tmp/uploaded)" = true ] || die "the second upload: $(cat /tmp/uploaded)"
  [ "$(field resumed_from /tmp/uploaded)" -gt 10000 ] || die "the second upload began anew: $(cat /tmp/uploaded)"
  figure "upload over $2: $(field bytes /tmp/uploaded) bytes, resumed at $(field resumed_from /tmp/uploaded), $(field rate_bytes_s /tmp/uploaded) B/s, $(field retried_blocks /tmp/uploaded) blocks twice"
}
