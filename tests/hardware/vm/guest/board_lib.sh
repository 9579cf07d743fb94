# thimble-board in the guest: its lines, its arm, its start and its end. Sourced after lib.sh.

board_as=

# The drivers of a board's devices. The watchdog says that it bites, and does not restart the machine.
load_devices() {
  modprobe -a gpio-sim arm_hardware
  modprobe softdog soft_noboot=1
}

# Lines of a simulated GPIO chip: ESTOP, DEAD_MAN and AMP_FAULT in, AMP_EN out, and those that are named.
make_lines() {
  chip=/sys/kernel/config/gpio-sim/board
  mkdir -p $chip/bank0
  echo 16 >$chip/bank0/num_lines
  n=0
  for name in ESTOP DEAD_MAN AMP_FAULT AMP_EN "$@"; do
    mkdir $chip/bank0/line$n
    echo $name >$chip/bank0/line$n/name
    n=$((n + 1))
  done
  echo 1 >$chip/live
  lines=/sys/devices/platform/$(cat $chip/dev_name)/$(cat $chip/bank0/chip_name)
  echo pull-up >$lines/sim_gpio2/pull  # AMP_FAULT: low is a fault
}
pull() { echo "pull-$2" >"$lines/sim_gpio$1/pull"; }
close_contacts() { pull 0 up; pull 1 up; sleep 0.1; }  # they settle in 20 ms
# After a start: gpio-sim takes the pull that the board asks for as the line's level, and so every contact is open.
# release_all [ADDRESS]
release_all() {
  close_contacts
  thimble fault clear --device "${1:-can:vcan0}" >/dev/null
}
press() {
  case $1 in
    e_stop) pull 0 down ;;
    dead_man) pull 1 down ;;
  esac
}
# The drive is on while the enable line is high and the heartbeat keeps the one-shot going.
one_shot=/sys/module/arm_hardware/parameters/one_shot
enable_line() { [ "$(cat "$lines/sim_gpio3/value")" = 1 ]; }
enabled() { enable_line && [ "$(cat $one_shot)" = 1 ]; }
not_enabled() { ! enabled; }

start_arm() {
  arm_plant --enable "$lines/sim_gpio3/value" --one-shot $one_shot --hand hand.csv >/tmp/arm 2>&1 &
  arm=$!
}
stop_arm() {
  kill -TERM $arm
  wait $arm || die "the arm ended with $?: $(cat /tmp/arm)"
}

# start_board [CONFIGURATION]; $board_as stands before the command.
start_board() {
  : >/tmp/board  # or the "ready" of the one before would be taken for this one's
  $board_as thimble-board --config "${1:-board.json}" >/tmp/board 2>/tmp/board.err &
  board=$!
  wait_until 20 grep -qx ready /tmp/board
}
stop_board() {
  kill -TERM $board || die "the board ended by itself: $(cat /tmp/board.err)"
  wait $board || die "the board ended with $?: $(cat /tmp/board.err)"
  cat /tmp/board.err
}

# board_check CODE TEXT [CONFIGURATION]: thimble-board --check ends with this code and says this.
board_check() {
  status=0
  $board_as thimble-board --config "${3:-board.json}" --check >/tmp/check 2>&1 || status=$?
  [ $status = "$1" ] && grep -q "$2" /tmp/check || die "--check ended with $status: $(cat /tmp/check)"
  cat /tmp/check
}

# The process that outlives the board, and a thread of the board, by their names.
guardian() { grep -l thimble-guard /proc/[0-9]*/comm | cut -d/ -f3; }
guardian_gone() { [ -z "$(guardian)" ]; }
thread_of() { basename "$(dirname "$(grep -l "$1" /proc/$board/task/*/comm)")"; }

# Every output of the converter at 0 V.
no_voltage() { [ "$(dd if=/dev/arm_hardware bs=32 count=1 2>/dev/null | od -An -td2 -N8 | tr -s ' ')" = ' 0 0 0 0' ]; }

# fault_is NAME [ADDRESS]
fault_is() { thimble fault list --device "${2:-can:vcan0}" | grep -q "$1"; }
# touches TICKS [ADDRESS]: the tip has been in contact for so many.
touches() {
  thimble info --device "${2:-can:vcan0}" --json >/tmp/info
  [ "$(field contact_ticks /tmp/info)" -ge "$1" ]
}
# refused REASON COMMAND...: the command is refused with this reason.
refused() {
  reason=$1
  shift
  ! "$@" >/tmp/refused 2>&1 || die "$* was accepted"
  grep -q "$reason" /tmp/refused || die "$* was refused for another reason: $(cat /tmp/refused)"
  head -1 /tmp/refused
}
