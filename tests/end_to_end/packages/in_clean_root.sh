#!/bin/sh
# Run in a root with Debian alone and what the packages depend on: installs them (*.deb beside this file), uses them as a user does, and removes them.
set -eu
here=$(dirname "$0")
cd "$here"
export HOME="$here/home" XDG_RUNTIME_DIR="$here/run" MPLCONFIGDIR="$here/home"
mkdir -p -m 700 "$HOME" "$XDG_RUNTIME_DIR"
listing() {  # every file but the copy of /etc/shadow that Debian 13 makes of the users before, the users and the packages
  find / -xdev \( -path /proc -o -path /sys -o -path /dev -o -path /run -o -path /tmp -o -path /var/lib/dpkg -o -path /var/log -o -path /var/cache -o -path /etc/shadow- \) \
    -prune -o -print | LC_ALL=C sort
  cut -d: -f1 /etc/passwd /etc/group | grep -vx thimble  # the user of thimble-board stays, as Debian's users of services do
  dpkg --get-selections
}
say() { printf '== %s\n' "$*"; }

listing >before
say install
apt-get install --yes ./*.deb
say manual pages, completion
man --where thimble thimble-sim thimble-board thimble-upload
test -s /usr/share/bash-completion/completions/thimble -a -s /usr/share/zsh/vendor-completions/_thimble -a -s /usr/share/fish/vendor_completions.d/thimble.fish
test -s /usr/share/doc/thimble-doc/html/index.html

say simulator
scenes=/usr/share/thimble/scenes
thimble-sim --tcp 0 --no-pty --name clean --hand $scenes/asteroid/stroke.csv --loop >sim.out &
sim=$!
for _ in $(seq 200); do ! grep -q ^ready sim.out || break; sleep 0.1; done
device=$(grep -m1 -o 'tcp:[0-9.:]*' sim.out)
thimble list | grep clean
thimble upload --device "$device" $scenes/asteroid/asteroid.scene.json
thimble home --device "$device"
thimble record felt.rec --device "$device" --scene $scenes/asteroid/asteroid.scene.json --arm --seconds 3
thimble info --device "$device" --json >info.json
thimble disarm --device "$device"
thimble replay felt.rec --log felt.csv
kill $sim
wait $sim || true
python3 -c 'import json; state = json.load(open("info.json"))["state"]; assert state["peak_force_N"] > 0.1, state'

say the same bytes as those of the machine that builds
mkdir there
for scene in $scenes/*/*.scene.json; do
  thimble compile "$scene" --output "there/$(basename "$scene" .scene.json).thim" >/dev/null
done
for name in blocks ice; do
  thimble simulate $scenes/$name/$name.scene.json --path $scenes/$name/stroke.csv --log there/$name.csv >/dev/null
done
diff -r here there

say doctor
thimble doctor
thimble doctor --json | python3 -c 'import json, sys; told = json.load(sys.stdin); assert told["findings"] and not told["failures"], told'

say view
thimble view --no-browser --scene $scenes/blocks/blocks.scene.json >view.out &
view=$!
for _ in $(seq 200); do ! grep -q http view.out || break; sleep 0.1; done
python3 - "$(head -1 view.out)" <<'PY'
import sys, urllib.request
with urllib.request.urlopen(sys.argv[1]) as answer:
    assert answer.status == 200 and b"<html" in answer.read(), answer
PY
kill $view
wait $view || true

say Python
python3 - <<'PY'
import thimble
felt = thimble.simulate("/usr/share/thimble/scenes/ring/ring.scene.json", "/usr/share/thimble/scenes/probe.csv", ideal=True, rate_Hz=1000)
assert abs(felt["force_N"]).max() > 0.1
PY

say a project outside
cmake -S outside -B build -G Ninja >cmake.out || { cat cmake.out; exit 1; }
cmake --build build
echo '{"thimble_scene": 1, "name": "floor", "objects": [{"name": "floor", "shape": {"plane": {"normal": [0, 0, 1]}},
  "material": {"stiffness_N_m": 500}}]}' >floor.scene.json
build/outside floor.scene.json /usr/share/thimble/arms/falcon.arm.json | tee outside.out
grep -q '"rendered_N": 1.00000' outside.out

say the tutorials
mount -t devpts -o newinstance,mode=620,gid=5,ptmxmode=666 devpts /dev/pts  # who opens a terminal owns it; mmdebstrap mounts one with a fixed owner
trap 'umount /dev/pts' EXIT  # or the root cannot be removed
mkdir student
chown nobody:nogroup student
chmod 711 "$here"
HOME="$here/student" XDG_RUNTIME_DIR="$here/student" MPLCONFIGDIR="$here/student" \
  setpriv --reuid nobody --regid nogroup --clear-groups python3 -B tutorials.py

say remove
apt-get purge --yes $(for file in ./*.deb; do dpkg-deb --field "$file" Package; done)
listing >after
diff before after
say nothing is left
