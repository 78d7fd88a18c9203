# 015-refusals: what the daemon's side says where it cannot start: one line, the right exit code, nothing left behind.
# SPDX-License-Identifier: Apache-2.0
. "$(dirname "$0")/private.sh"
refused() { # CODE PATTERN OPTIONS...: at most 3 s
  local code=$1 pattern=$2; shift 2
  timeout 3 $BIN/vdisp-publish --frames 1 "$@" > $WORK/out 2> $WORK/err
  local got=$?
  [ $got = $code ] && [ "$(wc -l < $WORK/err)" = 1 ] && grep -q "$pattern" $WORK/err || fail "$* : $got, wanted $code /$pattern/: $(cat $WORK/out $WORK/err)"
  echo "$code: $(cat $WORK/err)"
}
refused 78 "memory = 3 MiB.*need 6.*x 307328" --memory 3
refused 78 "no group 'no-such-group'" --group no-such-group
refused 78 "no comma" --name a,b
(ulimit -n 20; refused 71 "may open 20 files, needed are 64") || exit 1
# A fatal error inside iceoryx: a line and a code, no abort. (Sanitizers need more address space than this themselves.)
grep -q __asan_init $BIN/vdisp-publish || (ulimit -v 60000; refused 71 "iceoryx gave up") || exit 1
$BIN/vdisp-publish > $WORK/first & FIRST=$!; wait_for $WORK/first ready
refused 69 "vdisp-publish, pid $FIRST"
kill -TERM $FIRST; wait $FIRST || fail "SIGTERM: $?"
flock -o /tmp/roudi.lock sleep 4 & sleep 0.1
refused 69 "/tmp/roudi.lock"
kill $(jobs -p); wait 2>/dev/null
$BIN/vdisp-reader impostor 2 & sleep 0.2
refused 69 "served by another program"
wait
# iceoryx's own RouDi, as another program on the rover may have started it: refused by the daemon, and no daemon to a reader
if command -v iox-roudi > /dev/null; then
  iox-roudi > $WORK/roudi 2>&1 & ROUDI=$!; wait_for $WORK/roudi "ready for clients"
  refused 69 "iox-roudi, pid $ROUDI"
  timeout 5 "${DAEMON[@]}" --frames 1 > $WORK/out 2> $WORK/err; [ $? = 69 ] && grep "iox-roudi, pid $ROUDI" $WORK/err || fail "vdispd beside iox-roudi: $(cat $WORK/err)"
  $BIN/vdisp-probe list > $WORK/out 2>&1; [ $? = 69 ] && grep "is it no vdispd" $WORK/out || fail "vdisp-probe with iox-roudi: $(cat $WORK/out)"
  kill -TERM $ROUDI; wait $ROUDI 2>/dev/null
  rm -f /tmp/roudi* /tmp/*.lock /dev/shm/*
else
  echo "not tested: iox-roudi (Debian package iceoryx) is not installed"
fi
mount -t tmpfs -o size=60m,mode=1777 none /dev/shm
refused 71 "60 MiB free.*needed are 73 MiB"
umount /dev/shm
mount -o remount,ro /dev/shm; refused 77 "/dev/shm"; mount -o remount,rw /dev/shm
rm -f /tmp/roudi* /tmp/*.lock /dev/shm/*
# leftovers of a daemon that was killed, run by another user, are no obstacle to root
setpriv --reuid 65534 --regid 65534 --clear-groups $BIN/vdisp-publish > $WORK/nobody & NOBODY=$!; wait_for $WORK/nobody ready
kill -9 $NOBODY; wait 2>/dev/null
timeout 5 $BIN/vdisp-publish --frames 3 > $WORK/after || fail "after another user's daemon was killed: $?"
# but root's are one to another user
$BIN/vdisp-publish > $WORK/first & FIRST=$!; wait_for $WORK/first ready; kill -9 $FIRST; wait 2>/dev/null
setpriv --reuid 65534 --regid 65534 --clear-groups $BIN/vdisp-publish > $WORK/out 2> $WORK/err; [ $? = 77 ] && grep -q "belongs to user root" $WORK/err || fail "leftovers of root: $(cat $WORK/err)"
cat $WORK/err
echo passed
