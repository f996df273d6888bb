#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# ./run and ./check on a machine that has nothing: a Debian root of about 150 MB, without compiler, git, Python or sudo.
#
#     tests/bare_machine/try.sh DIRECTORY [COMMAND…]      as root; needs debootstrap and a Debian mirror
#
# Makes DIRECTORY/root (kept and reused: remove it to start afresh), copies the last commit into it, and runs the commands
# there, by default ./run and ./check, without a terminal and without this machine's environment. Set SUITE (bookworm) and
# MIRROR for another Debian. Exit status 0 if every command ended with 0.
set -euo pipefail
[ $# -ge 1 ] || { sed -n '3,11s/^# \{0,1\}//p' "$0"; exit 2; }
checkout=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
mkdir -p "$1"
root=$(cd "$1" && pwd)/root
shift
[ $# -gt 0 ] || set -- ./run ./check

if [ ! -x "$root/bin/bash" ]; then
  # For a suite that debootstrap has no script for, the script of sid is the right one.
  as=()
  [ -e "/usr/share/debootstrap/scripts/${SUITE:-bookworm}" ] || as=(sid)
  debootstrap --variant=minbase "${SUITE:-bookworm}" "$root" "${MIRROR:-http://deb.debian.org/debian}" ${as[@]+"${as[@]}"} > "$root.log" 2>&1 \
    || { tail -n 25 "$root.log"; exit 1; }
fi
cp /etc/resolv.conf "$root/etc/resolv.conf"

mkdir -p "$root/qdot"
find "$root/qdot" -mindepth 1 -maxdepth 1 ! -name build -exec rm -rf {} + # what was built is kept
git -C "$checkout" archive HEAD | tar -x -C "$root/qdot"

mountpoint -q "$root/proc" || mount -t proc proc "$root/proc"
trap 'umount "$root/proc"' EXIT

status=0
for command in "$@"; do
  echo "--- $command"
  start=$SECONDS
  code=0
  env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root \
    chroot "$root" /bin/bash -c "cd /qdot && $command" < /dev/null || code=$?
  echo "--- $command: exit status $code after $((SECONDS - start)) s"
  [ $code = 0 ] || status=1
done
exit $status
