#!/bin/sh
# The event line of thimble-board: a pulse for each event and switch of the trial, in the tick that a recording has, and low when the board is gone.
. /usr/local/bin/lib.sh
. /usr/local/bin/board_lib.sh

load_devices
make_lines EVENT
mkdir /tmp/store
ip link add dev vcan0 type vcan
ip link set vcan0 mtu 72 up
device='--device can:vcan0'
line=$lines/sim_gpio4/value
low() { [ "$(cat "$line")" = 0 ]; }
sed 's|"heartbeat"|"event": { "line": "EVENT", "active": "high" }, &|' board.json >/tmp/event.json

step 'what --check says'
board_check 0 'nothing is missing' /tmp/event.json
sed 's|"EVENT"|"NOWHERE"|' /tmp/event.json >/tmp/nowhere.json
board_check 3 'GPIO line "NOWHERE"' /tmp/nowhere.json
thimble-board --config /tmp/event.json --uses "/dev/$(gpiofind EVENT | cut -d' ' -f1)" || die 'the chip of the event line is not named'

step 'events and a trial, in a recording'
start_arm
start_board /tmp/event.json
release_all
thimble upload walls.thim $device >/dev/null
thimble home $device >/dev/null
line_edges "$line" >/tmp/edges &
watch=$!
thimble record /tmp/felt.rec --scene walls.thim --seconds 12 $device >/tmp/record 2>&1 &
recorder=$!
wait_until 20 grep -q recording /tmp/record
for code in 7 65535 0 7 7; do thimble param set event $code $device >/dev/null; done
thimble param set trial 3 $device >/dev/null
wait $recorder || die "the recording ended with $?: $(cat /tmp/record)"
kill -TERM $watch
thimble replay /tmp/felt.rec --events /tmp/events.csv || die 'the replay differs'
cat /tmp/events.csv /tmp/edges
cut -d, -f3,4 /tmp/events.csv | tr '\n' ' ' >/tmp/told
[ "$(cat /tmp/told)" = 'kind,code event,7 event,65535 event,0 event,7 event,7 trial,3 ' ] || die "other events: $(cat /tmp/told)"
# 1000 ticks a second, ten looks a tick: the edges are as far from each other as the ticks of the recording, within the jitter of a tick.
sed 1d /tmp/events.csv | cut -d, -f1 >/tmp/ticks
awk '
  NR == FNR { tick[n++] = $1; next }
  $2 == 1 { rise[r++] = $1 }
  $2 == 0 { width = ($1 - rise[r - 1]) / 1e6; if (!f++ || width < least) least = width; if (width > most) most = width }
  END {
    for (i = 1; i < n; ++i) {
      off = (rise[i] - rise[0]) / 1e6 - (tick[i] - tick[0])
      if (off < 0) off = -off
      if (off > worst) worst = off
    }
    printf "%d edges, at most %.2f ticks from where the recording has them; pulses of %.2f to %.2f ms\n", r, worst, least, most
    exit !(n == 6 && r == n && f == n && worst < 0.9 && least > 9 && most < 11)
  }' /tmp/ticks /tmp/edges >/tmp/compared || die "$(cat /tmp/compared)"
figure "$(cat /tmp/compared)"

step 'the board is killed in a pulse'
line_edges "$line" $board >/tmp/edges &
watch=$!
thimble param set event 1 $device >/dev/null 2>&1 || true  # its answer may be lost with the board
wait $board && die 'the board lives' || true
wait_until 5 guardian_gone
wait_until 2 low
kill -TERM $watch
cat /tmp/edges
[ "$(cut -d' ' -f2 /tmp/edges | tr '\n' ' ')" = '1 0 ' ] || die 'no pulse, or more than one'

step 'it starts with the line low, and ends so'
start_board /tmp/event.json
release_all
low || die 'the line is active'
stop_board
low || die 'the line is active after the end'
stop_arm
echo passed
