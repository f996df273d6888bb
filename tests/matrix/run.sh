#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# What ./check leaves out: other versions of what qdot needs, and compilers with other settings. It takes hours.
#
#     ./check --matrix [ROW…]
#
# debian    ./check in a root of the next Debian: its g++ and clang++, Eigen 5, SUNDIALS 7 and Catch2 3. As root, with debootstrap
# libc++    the laws and the examples by clang++ with LLVM's standard library
# gnu++20   the examples with the compiler's extensions, by g++ and by clang++
# c++23     the examples in C++23, by both
# no-rtti   the examples without run-time type information, by both
# strict    a project that takes qdot by FetchContent with all of clang's warnings as errors
# aarch64   the machine code for AArch64, in an emulator
#
# Without a ROW all are run, each in a folder of its own in build/matrix. `debian` takes the last commit, the others the working tree. A line for each row
# says how it ended; the exit status is 0 if all passed.
# Set SUITE (forky) for another Debian.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$root/cmake/prepare.sh"

all=(debian libc++ gnu++20 c++23 no-rtti strict aarch64)
rows=("$@")
[ $# -gt 0 ] || rows=("${all[@]}")
for row in "${rows[@]}"; do
  [[ " ${all[*]} " == *" $row "* ]] || { say "./check --matrix: no row $row; rows are ${all[*]}"; exit 2; }
done

clang=$(find_clang)
mkdir -p "$root/build/matrix"

# Installs packages of this Debian, where that is possible without a question.
install() {
  local as_root=""
  [ "$(id -u)" = 0 ] || as_root="sudo -n"
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "$@" > "$root/build/matrix/install.log" 2>&1 < /dev/null
}

# Builds a target by one compiler with some options, and runs the tests of some names.
tested() { # tested DIRECTORY COMPILER TARGET TESTS OPTION…
  local directory=$root/build/matrix/$1 target=$3 tests=$4
  export CXX=$2
  shift 4
  mkdir -p "$directory"
  configure "$directory" -DCMAKE_BUILD_TYPE=Check -DQDOT_TESTS=LAWS -DQDOT_BUILD_PROGRAM=OFF -DQDOT_EXAMPLES_TOGETHER=ON "$@"
  compile "$directory" --target "$target" || { grep -E -m 10 'error:' "$directory/build.log" || show_end_of "$directory/build.log"; return 1; }
  ctest --test-dir "$directory" --parallel "$(jobs)" --no-tests=error --output-on-failure --timeout 1200 -LE long -R "$tests" > "$directory/test.log" 2>&1 ||
    { sed -n '/^The following tests FAILED/,$p' "$directory/test.log"; return 1; }
}
examples_by_both() { # examples_by_both ROW OPTION…
  local row=$1
  shift
  tested "$row-g++" g++ qdot_examples '^example\.[0-9]' "$@"
  tested "$row-clang++" "$clang" qdot_examples '^example\.[0-9]' "$@"
}

debian() {
  local suite=${SUITE:-forky} log=$root/build/matrix/debian.log
  SUITE=$suite "$root/tests/bare_machine/try.sh" "$root/build/matrix/debian-$suite" ./check > "$log" 2>&1 || { tail -n 5 "$log"; return 1; }
}
libc++() {
  local version
  version=$(printf __clang_major__ | "$clang" -E -P -x c -)
  echo '#include <version>
int main() {}' | "$clang" -std=c++20 -stdlib=libc++ -x c++ - -o "$root/build/matrix/libc++.out" 2> /dev/null ||
    install "libc++-$version-dev" "libc++abi-$version-dev" || { tail -n 5 "$root/build/matrix/install.log"; return 1; }
  # The C++ interfaces of Ipopt and Open MPI are compiled for libstdc++.
  tested libc++ "$clang" all . -DCMAKE_CXX_FLAGS=-stdlib=libc++ -DQDOT_WITH_IPOPT=OFF -DQDOT_WITH_MPI=OFF
}
gnu++20() { examples_by_both gnu++20 -DCMAKE_CXX_EXTENSIONS=ON; }
c++23() { examples_by_both c++23 -DCMAKE_CXX_STANDARD=23; }
no-rtti() { examples_by_both no-rtti -DCMAKE_CXX_FLAGS=-fno-rtti; }
strict() {
  local directory=$root/build/matrix/strict
  export CXX=$clang
  cmake -S "$root/tests/package/fetch_content" -B "$directory" -DCMAKE_CXX_COMPILER="$clang" -DCMAKE_BUILD_TYPE=Debug -DQDOT_CHECKOUT="$root" \
    > "$directory.log" 2>&1 && cmake --build "$directory" >> "$directory.log" 2>&1 && "$directory/user" >> "$directory.log" 2>&1 ||
    { grep -E -m 10 'error:' "$directory.log" || show_end_of "$directory.log"; return 1; }
}
aarch64() {
  provide_if_possible aarch64 "A compiler or emulator for AArch64"
  "$root/tests/aarch64/native_lines.sh" "$root" /usr/include/eigen3 /usr/include > "$root/build/matrix/aarch64.log" 2>&1 ||
    { tail -n 5 "$root/build/matrix/aarch64.log"; return 1; }
  ! grep -q "needs" "$root/build/matrix/aarch64.log" || { cat "$root/build/matrix/aarch64.log"; return 1; }
}

failed=0
for row in "${rows[@]}"; do
  start=$SECONDS
  status=passed
  case $row in
    debian | aarch64) ;;
    *) [ -n "$clang" ] || { say "$row: failed, there is no clang++ 16 or newer with its sanitizers"; failed=$((failed + 1)); continue; } ;;
  esac
  # In a process of its own. Within `if` bash would ignore -e.
  set +e
  (set -e; "$row") 1>&2
  [ $? = 0 ] || { status=failed; failed=$((failed + 1)); }
  set -e
  echo "$row: $status after $((SECONDS - start)) s"
done
echo "$((${#rows[@]} - failed)) rows passed, $failed failed"
[ $failed = 0 ]
