#!/usr/bin/env bash
# run-vm.sh itself: what its script ends with is what it ends with, and a machine that hangs or dies is no success.
set -euo pipefail
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# expect STATUS LINE... [-- OPTION...]: a script of these lines makes run-vm.sh end so.
expect() {
  local wanted=$1 script=$folder/script status=0
  shift
  echo '#!/bin/sh' >"$script"
  while [ $# -gt 0 ] && [ "$1" != -- ]; do echo "$1" >>"$script"; shift; done
  "$here/run-vm.sh" -t 60 -o "$folder/out" -e 'SAID=two words' "${@:2}" "$script" >"$folder/log" 2>&1 || status=$?
  if [ "$status" -ne "$wanted" ]; then
    echo "run-vm.sh ended with $status, not $wanted:"
    cat "$folder/log"
    exit 1
  fi
}

expect 0 'set -e' 'ip link add dev vcan0 type vcan' '[ "$SAID" = "two words" ]' 'echo heard >/out/heard'
grep -qx heard "$folder/out/heard"
expect 3 'exit 3'
expect 45 'exit 200'
expect 124 'sleep 1000' -- -t 10
expect 125 'echo c >/proc/sysrq-trigger'  # the kernel panics
echo 'as expected'
