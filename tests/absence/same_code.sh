#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# same_code.sh COMPILER SOURCE_DIR INCLUDE…: what a scene does not name is not in its code. Compiles one evaluation of q̈ for
# bare systems, of T and V and of positions, and for scenes of them without effects, and compares how many instructions of
# each kind there are, padding apart (their order and registers are the compiler's, and it may choose others for another
# type's name). Then with effects, where they must differ, so that the comparison is known to see something. That an effect
# switched off leaves the same type as an absent one, beside constraints too, is asserted in the source.
set -euo pipefail
compiler=$1 here=$2
shift 2
includes=()
for path; do includes+=(-isystem "$path"); done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# What all of them include is read once: each then finds its headers read, as #pragma once says.
options=(-std=c++20 -O2 -DNDEBUG -DQDOT_COMPILED -w "${includes[@]}")  # what depends on no functor is compiled elsewhere
grep '^#include' "$here/evaluation.cpp" > "$work/headers.hpp"
"$compiler" "${options[@]}" -x c++-header "$work/headers.hpp" -o "$work/headers.hpp.gch"

instructions() { # of everything that SUBJECT $1 is compiled to: no addresses, no names
  "$compiler" "${options[@]}" -include "$work/headers.hpp" "-DSUBJECT=$1" -c "$here/evaluation.cpp" -o "$work/evaluation.o"
  objdump -d --no-show-raw-insn "$work/evaluation.o" |
    awk '/^ *[0-9a-f]+:\t/ { sub(/^ *[0-9a-f]+:\t/, ""); if ($0 !~ /^(nop|data16|cs nop|xchg +%ax,%ax)/) print $1 }' | sort
}

status=0
same() { # the bare system $1, and the scene $2
  instructions "$1" > "$work/bare"
  instructions "$2" > "$work/scene"
  local count
  count=$(wc -l < "$work/bare")
  [ "$count" -gt 20 ] || { echo "no instructions found in the evaluation of $1"; exit 1; }
  if cmp -s "$work/bare" "$work/scene"; then
    echo "the same $count instructions: $1 and $2"
  else
    echo "DIFFERENT: $1 has $count instructions, $2 $(wc -l < "$work/scene")"
    diff "$work/bare" "$work/scene" | head -n 10 || true
    status=1
  fi
}

same "positions()" "scene(positions(), qdot::optional<false>(damping()))"
same "cart()" "scene(cart())"
for subject in "scene(cart(), damping())" "scene(cart(), track())"; do
  instructions "$subject" > "$work/other"
  if cmp -s "$work/bare" "$work/other"; then echo "the comparison does not see the effect: $subject"; status=1; fi
  echo "$(wc -l < "$work/other") instructions: $subject"
done
exit $status
