# private.sh: sourced first by each system test: its own /tmp, /dev/shm and /run, so that daemons do not meet. BIN is the folder of the programs.
# SPDX-License-Identifier: Apache-2.0
# Ends the test with 77 (skipped) where mount namespaces are not permitted.
if [ -z "$VDISP_PRIVATE" ]; then
  if ! unshare -m true 2>/dev/null; then
    echo "skipped: unshare -m is not permitted (run as root)"
    exit 77
  fi
  VDISP_PRIVATE=1 exec unshare -m bash "$0" "$@"
fi
BIN=$1
mount --make-rprivate / && mount -t tmpfs -o mode=1777 none /dev/shm && mount -t tmpfs -o mode=1777 none /tmp && mount -t tmpfs -o mode=755 none /run || exit 77
WORK=/tmp/work && mkdir $WORK && cp "$BIN"/vdisp-* "$BIN"/vdispd "$BIN"/vdisp_sim.so $WORK && chmod -R a+rx $WORK && BIN=$WORK  # also for users who cannot see the build
trap 'kill -9 $(jobs -p) 2>/dev/null; wait 2>/dev/null' EXIT
# The daemon itself, small and at 30 Hz; a test may put more options behind these.
DAEMON=("$BIN/vdispd" --sim --set sim.width=160 --set sim.height=120 --set "image source.ndisp=32" --set sim.rate=30)
READY="vdispd: ready"   # on stderr, after the first step
stamped() { while IFS= read -r line; do echo "${EPOCHREALTIME/./} $line"; done; }
fail() { echo "FAILED: $*"; exit 1; }
# The number behind WORD in FILE, the last one.
value() { sed -n "s/.*\b$2 \([0-9.]*\).*/\1/p" "$1" | tail -1; }
# steady FILE LEAST WHY: a reader that counted saw so many frames and missed none; up to one in 50 it may have slept through.
steady() {
  [ "$(value $1 frames)" -ge $2 ] && [ "$(value $1 missed)" = 0 ] && [ "$(value $1 asleep)" -le $(($(value $1 frames) / 50)) ] || fail "$3: $(cat $1)"
}
wait_for() { # FILE PATTERN: at most 5 s
  for _ in $(seq 100); do grep -q "$2" "$1" 2>/dev/null && return 0; sleep 0.05; done
  fail "no '$2' in $1: $(cat "$1")"
}
