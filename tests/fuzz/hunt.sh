#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)

help() {
  cat <<'END_OF_HELP'
tests/fuzz/hunt.sh [CASES [SEED [FIRST]]]   builds tests/fuzz/hunt with optimization and without sanitizers (some minutes the first
                                            time) and runs CASES (default 1000) of SEED (default 1), from number FIRST (default 0) on
Random T and V, places, scenes and motions, through every door and by every method, against hyperdual numbers in quadruple precision; motions in
other units, switches by place and time, and plates on many legs, against what is known of them.
A finding is printed with its seed and case, and the model in words: hunt.sh 1 SEED CASE gives that case again. Exit status 0: there
was no finding; 1: there was one. QDOT_FUZZ_TYPES=N makes other types of functors, QDOT_FUZZ_OPTIMIZATION is one of the compiler's (-O2).
Needs g++ (for libquadmath), CMake, Eigen and SUNDIALS.
END_OF_HELP
}

case ${1:-} in --help | -h) help; exit 0 ;; esac
out=$root/build/fuzz/hunt
mkdir -p "$out"
{
  cmake -S "$root/tests/fuzz/hunt" -B "$out" -DCMAKE_CXX_COMPILER="${CXX:-g++}" -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_CXX_FLAGS_RELEASE="${QDOT_FUZZ_OPTIMIZATION:--O2}" -DQDOT_FUZZ_TYPES="${QDOT_FUZZ_TYPES:-1}" &&
    cmake --build "$out" --parallel "$(nproc)"
} > "$out/build.log" 2>&1 || { tail -n 40 "$out/build.log"; exit 3; }
exec "$out/hunt" "${@:1:3}"
