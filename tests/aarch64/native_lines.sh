#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The machine code for AArch64: the tests of ad/native_lines, compiled for that processor and run by an emulator.
#
#     native_lines.sh SOURCE-DIRECTORY INCLUDE-DIRECTORIES…
set -euo pipefail
source=$1
shift
compiler=aarch64-linux-gnu-g++
if ! command -v $compiler > /dev/null || ! command -v qemu-aarch64 > /dev/null; then
  echo "The machine code for AArch64 needs $compiler and qemu-aarch64"
  exit 0
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
include=()
for directory in "$@"; do include+=(-idirafter "$directory"); done
$compiler -std=c++20 -O1 -static -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror -I"$source/include" -I"$source/src" -I"$source/tests" \
  ${include[@]+"${include[@]}"} "$source/tests/ad/native_lines.test.cpp" "$source/tests/catch2_main.cpp" -o "$work/native_lines"
# An emulator takes no limit of memory.
qemu-aarch64 "$work/native_lines" '~where the system refuses memory*'
