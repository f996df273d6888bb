#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)

help() {
  cat <<'END_OF_HELP'
tests/fuzz/run.sh [SECONDS]     builds every tests/fuzz/*.fuzz.cpp with clang's libFuzzer and the sanitizers, runs each for
                                SECONDS (default 60), then mutates the command line for as long; no part of ./check
What is found is printed, and kept in build/fuzz. Exit status 0: nothing was found. Set CXX for another clang++,
QDOT_FUZZ_LAUNCHER for a command in front of each build and run.
END_OF_HELP
}

case ${1:-} in --help | -h) help; exit 0 ;; esac
seconds=${1:-60}
out=$root/build/fuzz
mkdir -p "$out"
for CXX in ${CXX:-} clang++ clang++-2{0..9} clang++-1{9..6} none; do ! command -v "$CXX" > /dev/null || break; done
[ "$CXX" != none ] || { echo "No clang++ found. On Debian: apt-get install clang-16" >&2; exit 3; }
# clang looks for g++'s libquadmath beside the compiler that has it.
quadmath=$(dirname "$(g++ -print-file-name=libquadmath.so)")
eigen=${EIGEN_INCLUDE:-/usr/include/eigen3}

cd "$out"
for source in "$root"/tests/fuzz/*.fuzz.cpp; do
  name=$(basename "$source" .fuzz.cpp)
  ${QDOT_FUZZ_LAUNCHER:-} "$CXX" -std=c++20 -O1 -g1 -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all -I "$root/include" \
    -I "$root/tests" -isystem "$eigen" "$source" -L "$quadmath" -lquadmath -o "$name"
  mkdir -p "corpus-$name"
  ${QDOT_FUZZ_LAUNCHER:-} ./"$name" -max_total_time="$seconds" -timeout=10 "corpus-$name" > "$name.log" 2>&1 || {
    grep -v "NEW_FUNC\|^#" "$name.log" | tail -n 40
    exit 1
  }
  echo "$name: $seconds s, nothing found, $(find "corpus-$name" -type f | wc -l) inputs kept"
done
if [ -x "$root/build/run/qdot" ]; then
  python3 "$root/tests/fuzz/command_line.py" --seconds "$seconds" --seed "$RANDOM" "$root/build/run/qdot"
fi
