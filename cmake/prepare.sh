# SPDX-License-Identifier: MIT
#
# What ./run and ./check share: finding or installing what the build needs, and building with a quiet log.
# Sourced by bash. Everything said here goes to stderr: stdout belongs to the program.
#
# Set by the caller: root (the checkout), with_sundials (yes or no).

say() { printf '%s\n' "$*" >&2; }

# Exit status 3: not set up or not built. (0, 1 and 2 are the program's own.)
stop() { say "$@"; exit 3; }

# --- What the machine has ---------------------------------------------------------------------------------------------

find_compiler() {
  local name
  for name in ${CXX:+"$CXX"} c++ g++ clang++; do
    if command -v "${name%% *}" > /dev/null; then printf '%s' "$name"; return; fi
  done
}

# Clang 16 or newer that links its sanitizers, or nothing: Debian packages those apart.
find_clang() {
  local name
  for name in clang++ clang++-{30..16}; do
    if command -v "$name" > /dev/null && printf '#if __clang_major__ < 16\n#error too old\n#endif\nint main() {}\n' |
        "$name" -std=c++20 -fsanitize=address,undefined -x c++ -o /dev/null - > /dev/null 2>&1; then
      printf '%s' "$name"
      return
    fi
  done
}

# By trying, not by package name: whoever installed it, and however, it counts.
has_header() { # has_header COMPILER HEADER
  printf '#if !__has_include(<%s>)\n#error missing\n#endif\n' "$2" | $1 -x c++ -E \
    -I/usr/include/eigen3 -I/usr/local/include/eigen3 -I/usr/local/include \
    -I/opt/homebrew/include -I/opt/homebrew/include/eigen3 - > /dev/null 2>&1
}

# Prints, one a line, the missing things by the names of this table's first column.
missing_things() { # missing_things THING…
  local thing compiler
  compiler=$(find_compiler)
  for thing in "$@"; do
    case $thing in
      compiler) [ -n "$compiler" ] ;;
      cmake) command -v cmake > /dev/null ;;
      ninja) command -v ninja > /dev/null || command -v make > /dev/null ;;
      # What apt-get installs is that Python's which lies in /usr/bin, and need not be the first one.
      sphinx) python3 -c 'import sphinx, myst_parser, furo' 2> /dev/null || /usr/bin/python3 -c 'import sphinx, myst_parser, furo' 2> /dev/null ;;
      aarch64) command -v aarch64-linux-gnu-g++ > /dev/null && command -v qemu-aarch64 > /dev/null ;;
      ccache) command -v ccache > /dev/null ;;
      # A user who says where the libraries are is believed; CMake will tell.
      *) [ -n "${CMAKE_PREFIX_PATH:-}" ] || case $thing in
           eigen) [ -n "$compiler" ] && has_header "$compiler" Eigen/Core ;;
           sundials) [ -n "${SUNDIALS_ROOT:-}" ] || { [ -n "$compiler" ] && has_header "$compiler" cvode/cvode.h; } ;;
           ipopt) [ -n "${IPOPT_ROOT:-}" ] || { [ -n "$compiler" ] && { has_header "$compiler" coin/IpTNLP.hpp || has_header "$compiler" coin-or/IpTNLP.hpp; }; } ;;
           cli11) [ -n "$compiler" ] && has_header "$compiler" CLI/CLI.hpp ;;
           json) [ -n "$compiler" ] && has_header "$compiler" nlohmann/json.hpp ;;
           catch2) [ -n "$compiler" ] && { has_header "$compiler" catch2/catch.hpp || has_header "$compiler" catch2/catch_all.hpp; } ;;
         esac ;;
    esac || printf '%s\n' "$thing"
  done
}

package_names() { # package_names SYSTEM THING…
  local system=$1 thing
  shift
  for thing in "$@"; do
    case $system:$thing in
      apt:compiler) printf 'g++ ' ;;                  dnf:compiler) printf 'gcc-c++ ' ;;
      apt:ninja | dnf:ninja) printf 'ninja-build ' ;; *:ninja) printf 'ninja ' ;;
      apt:eigen) printf 'libeigen3-dev ' ;;           dnf:eigen) printf 'eigen3-devel ' ;;
      apt:sundials) printf 'libsundials-dev ' ;;      dnf:sundials) printf 'sundials-devel ' ;;
      apt:ipopt) printf 'coinor-libipopt-dev ' ;;     dnf:ipopt) printf 'coin-or-Ipopt-devel ' ;;
      apt:cli11) printf 'libcli11-dev ' ;;            dnf:cli11) printf 'cli11-devel ' ;;
      apt:json) printf 'nlohmann-json3-dev ' ;;       dnf:json) printf 'json-devel ' ;;
      apt:sphinx) printf 'python3-sphinx python3-myst-parser furo ' ;; *:sphinx) printf 'sphinx myst-parser furo ' ;;
      apt:aarch64) printf 'g++-aarch64-linux-gnu qemu-user ' ;; *:aarch64) printf 'gcc-c++-aarch64-linux-gnu qemu-user ' ;;
      dnf:catch2) printf 'catch2-devel ' ;;           conda:compiler) printf 'cxx-compiler ' ;;
      brew:compiler) printf 'llvm ' ;;                brew:json | conda:json) printf 'nlohmann_json ' ;;
      brew:json) printf 'nlohmann-json ' ;;           *) printf '%s ' "$thing" ;;
    esac
  done
}

# --- Installing what is missing -----------------------------------------------------------------------------------------

provide() { # provide THING…
  local missing packages as_root=""
  missing=$(missing_things "$@")
  if [ -n "$missing" ]; then
    missing=$(printf '%s ' $missing)
    if ! command -v apt-get > /dev/null; then
      say "qdot needs: $missing"
      say "  Fedora:     sudo dnf install $(package_names dnf $missing)"
      say "  Homebrew:   brew install $(package_names brew $missing)"
      say "  conda:      conda install -c conda-forge $(package_names conda $missing)"
      stop "Install them and start again."
    fi
    packages=$(package_names apt $missing)
    packages=${packages% }
    case $missing in
      *sundials*) say "Installing $packages: with SUNDIALS 252 MB to download (without: 114 MB, see --no-sundials)" ;;
      *) say "Installing $packages" ;;
    esac
    if [ "$(id -u)" != 0 ]; then
      if ! command -v sudo > /dev/null; then
        stop "This needs root. Type as root:  apt-get install --no-install-recommends $packages"
      fi
      as_root="sudo"
      [ -t 0 ] || as_root="sudo -n"
    fi
    # A source of packages that does not answer is no reason to stop: install says whether it mattered.
    mkdir -p "$root/build"
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get update > "$root/build/install.log" 2>&1 < /dev/null || true
    if ! $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends $packages \
        >> "$root/build/install.log" 2>&1 < /dev/null; then
      show_end_of "$root/build/install.log"
      stop "Not installed. Type:  sudo apt-get update && sudo apt-get install --no-install-recommends $packages"
    fi
  fi

  refuse_old_tools
}

# Clang is a help, not a need: where it can be installed without a question, it is; prints its name, or nothing.
provide_clang() {
  local clang as_root="" version packages
  clang=$(find_clang)
  if [ -z "$clang" ] && command -v apt-get > /dev/null; then
    [ "$(id -u)" = 0 ] || as_root="sudo -n"
    mkdir -p "$root/build"
    {
      $as_root env DEBIAN_FRONTEND=noninteractive apt-get update || true
      for version in {16..30} ""; do
        [[ $(LC_ALL=C apt-cache policy clang-"$version") != *"Candidate: "[0-9]* ]] || break
      done
    } > "$root/build/install_clang.log" 2>&1 < /dev/null
    [ -n "$version" ] || { say "No clang++ 16 or newer to install (see build/install_clang.log); g++ compiles the laws, more slowly"; return 0; }
    packages=(clang-"$version" libclang-rt-"$version"-dev clang-format-"$version")
    say "Installing ${packages[*]}: 40 MB to download, and it compiles the laws in half the time that g++ takes"
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${packages[@]}" \
      >> "$root/build/install_clang.log" 2>&1 < /dev/null || say "Not installed (why: build/install_clang.log); g++ will do it, more slowly"
    clang=$(find_clang)
  fi
  printf '%s' "$clang"
}

# FMPy looks at what qdot_add_fmu makes; without it the test that needs it is skipped.
provide_fmpy() {
  local place=$root/build/fmpy
  if command -v python3 > /dev/null && [ ! -x "$place/bin/fmpy" ]; then
    mkdir -p "$root/build"
    say "Installing FMPy in build/fmpy, where it takes 230 MB"
    { python3 -m venv "$place" && "$place/bin/pip" install fmpy; } > "$root/build/install_fmpy.log" 2>&1 < /dev/null ||
      say "Not installed (why: build/install_fmpy.log); one test is skipped"
  fi
  export QDOT_FMPY_PYTHON=$place/bin/python
}

# What some tests need or are faster with, where it can be installed without a question.
provide_if_possible() { # provide_if_possible THING NAME
  local as_root="" log=$root/build/install_$1.log
  # What could not be installed once is not tried again.
  if [ -n "$(missing_things "$1")" ] && command -v apt-get > /dev/null && [ ! -f "$log" ]; then
    say "Installing $2"
    [ "$(id -u)" = 0 ] || as_root="sudo -n"
    mkdir -p "$root/build"
    {
      $as_root env DEBIAN_FRONTEND=noninteractive apt-get update || true
      $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends $(package_names apt "$1")
    } > "$log" 2>&1 < /dev/null || say "$2 is not installed (why: build/install_$1.log, to be deleted before another try); a test is skipped, or takes longer"
  fi
}

refuse_old_tools() {
  # A compiler or a CMake that is there but too old is for the user to replace.
  local compiler version
  compiler=$(find_compiler)
  if ! printf '#include <concepts>\nstatic_assert(std::same_as<int, int>);\n' | $compiler -std=c++20 -x c++ -fsyntax-only - > /dev/null 2>&1; then
    stop "$compiler does not know C++20 ($($compiler --version 2>&1 | head -n 1)). qdot needs g++ 12, clang 16 or newer: set CXX to one."
  fi
  version=$(cmake --version | sed -n 's/^cmake version \([0-9]*\.[0-9]*\).*/\1/p')
  if [ "${version%%.*}" -lt 3 ] || { [ "${version%%.*}" = 3 ] && [ "${version#*.}" -lt 22 ]; }; then
    stop "CMake $version is too old: qdot needs 3.22 or newer (for example: pip install cmake)."
  fi
}

# --- Building ---------------------------------------------------------------------------------------------------------

# A unit of test files takes up to 5 GB with sanitizers, most take half of it: as many jobs as there are cores, or as fit into memory.
jobs() {
  local cores memory
  cores=$(getconf _NPROCESSORS_ONLN 2> /dev/null || echo 1)
  memory=$(sed -n 's/^MemAvailable: *\([0-9]*\) kB/\1/p' /proc/meminfo 2> /dev/null || true)
  memory=$(( ${memory:-4000000} / 4000000 ))
  [ "$memory" -ge 1 ] || memory=1
  echo $(( cores < memory ? cores : memory ))
}

show_end_of() { say "… the last lines of $1:"; tail -n 25 "$1" >&2; }

# One build at a time in a directory; the lock goes with the process.
lock() { # lock DIRECTORY
  mkdir -p "$1"
  if command -v flock > /dev/null; then
    exec 9> "$1/lock"
    flock -n 9 || { say "Waiting for another build in $1"; flock 9; }
  fi
}

# Configures only what has not been configured just so; a checkout that was moved starts afresh.
configure() { # configure DIRECTORY OPTION…
  local directory=$1 wanted generator=""
  shift
  wanted="$root $(find_compiler) ${CXXFLAGS:-} ${CMAKE_PREFIX_PATH:-} ${SUNDIALS_ROOT:-} ${IPOPT_ROOT:-} $*"
  if [ -f "$directory/configured" ] && [ "$(cat "$directory/configured")" = "$wanted" ]; then return; fi
  rm -rf "$directory/CMakeCache.txt" "$directory/CMakeFiles" "$directory/configured"
  ! command -v ninja > /dev/null || generator=Ninja
  if ! cmake -S "$root" -B "$directory" ${generator:+-G "$generator"} -DCMAKE_CXX_COMPILER="$(find_compiler)" "$@" \
      > "$directory/configure.log" 2>&1; then
    show_end_of "$directory/configure.log"
    stop "Not configured. The whole log: $directory/configure.log"
  fi
  printf '%s' "$wanted" > "$directory/configured"
}

# Writes what a build prints to a log, and how far it is to the terminal: a bar, or a line every so many seconds where there is none.
progress_line=never # or seconds
show_progress() { # show_progress LOG
  local line="" part status count done=0 all=0 begin=$SECONDS told=$SECONDS drawn=-1 bar=no filled empty
  if [ -t 2 ]; then
    bar=yes
    trap 'printf "\r\033[K" >&2; trap - INT; kill -INT $BASHPID' INT
  fi
  while true; do
    status=0
    IFS= read -r -t 1 part || status=$?
    line+=$part
    if [ $status = 0 ]; then
      printf '%s\n' "$line"
      if [[ $line =~ ^\[([0-9]+)/([0-9]+)\]\  ]]; then # ninja
        done=${BASH_REMATCH[1]}
        all=${BASH_REMATCH[2]}
      elif [[ $line =~ ^\[\ *([0-9]+)%\]\  ]]; then # make
        done=${BASH_REMATCH[1]}
        all=100
      fi
      line=""
    elif [ $status -le 128 ]; then # the end; above 128 a second has passed
      [ -z "$line" ] || printf '%s\n' "$line"
      break
    fi
    if [ $bar = yes ] && [ $drawn != $SECONDS ]; then
      drawn=$SECONDS
      count=0
      [ "$all" = 0 ] || count=$((40 * done / all))
      printf -v filled '%*s' $count ''
      printf -v empty '%*s' $((40 - count)) ''
      printf '\r  [%s%s] %s of %s, %d s ' "${filled// /#}" "$empty" "$done" "$all" $((SECONDS - begin)) >&2
    elif [ $bar = no ] && [ "$progress_line" != never ] && [ $((SECONDS - told)) -ge "$progress_line" ]; then
      told=$SECONDS
      say "  $done of $all built after $((SECONDS - begin)) s"
    fi
  done > "$1"
  [ $bar = no ] || printf '\r\033[K' >&2
}

compile() { # compile DIRECTORY ARGUMENT…
  local directory=$1
  shift
  if [ "${BASH_VERSINFO[0]}" -lt 4 ]; then # whose read does not tell a second that has passed from the end
    cmake --build "$directory" --parallel "$(jobs)" "$@" > "$directory/build.log" 2>&1
  else
    cmake --build "$directory" --parallel "$(jobs)" "$@" 2>&1 | show_progress "$directory/build.log"
  fi
}
