#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# run_test.sh CHECKOUT: what ./run promises to those who call it from elsewhere, with the program as users build it.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
fail() { echo "$@" >&2; exit 1; }

"$1/run" run rod_and_ring --set M=2 --set L=1.5 --set m=0.3 --set g=9.81 --set q0=0.4 --set q1=0.2 --set qdot0=0.1 --set qdot1=1 \
  --t-end 1 --rtol 1e-12 --atol 1e-12 --json > answer.json
[ "$(head -c 1 answer.json)" = "{" ] || fail "stdout is not JSON alone: $(head -n 3 answer.json)"
# Independent reference, to 8 digits: q = (3.23299963, −2.34938563), qdot = (11.03324647, −1.12282144).
for digits in 3.2329996 -2.3493856 11.033246 -1.1228214; do
  grep -q -e "$digits" answer.json || fail "$digits is not in: $(cat answer.json)"
done

# ./run list answers before anything is built, by a file.
"$1/run" list > stdout
cmp stdout "$1/src/scenes/list.txt" || fail "qdot list does not print src/scenes/list.txt; write it anew: ./run list > src/scenes/list.txt"
mkdir -p bare/cmake bare/src/scenes
cp "$1/run" bare
cp "$1/cmake/prepare.sh" bare/cmake
cp "$1/src/scenes/list.txt" bare/src/scenes
bare/run list > stdout
cmp stdout "$1/src/scenes/list.txt" || fail "./run list without a build does not show the scenes"
[ ! -e bare/build ] || fail "./run list builds something"

code=0
"$1/run" run no_such_scene > stdout 2> stderr || code=$?
[ $code = 2 ] || fail "an unknown scene ends with status $code, not 2"
[ ! -s stdout ] || fail "an unknown scene prints to stdout: $(cat stdout)"

if [ ! -e "$1/out" ]; then # a folder that is there is the user's
  "$1/run" > stdout 2> stderr
  for scene in rod_and_ring double_pendulum; do
    grep -q "^$scene: reached t = " stdout || fail "./run alone does not show $scene: $(cat stdout stderr)"
    [ -s "$1/out/$scene.html" ] || fail "./run alone does not write out/$scene.html"
  done
  rm -r "$1/out"
fi

"$1/run" run pendulum --out here > /dev/null
[ -s here.csv ] && [ -s here.npz ] && [ -s here.html ] || fail "--out here did not write here.csv, here.npz, here.html in the caller's folder"
