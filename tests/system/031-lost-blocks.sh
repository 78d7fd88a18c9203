# 031-lost-blocks: as 030, at 50 Hz and counted block by block: not one is lost with a reader that is killed, and the loop never allocates.
# SPDX-License-Identifier: Apache-2.0
. "$(dirname "$0")/private.sh"
nice -n -15 $BIN/vdisp-publish --rate 50 > $WORK/daemon & DAEMON=$!; wait_for $WORK/daemon ready
# Before the crowd in the queue for the processor: what is tested is the memory, not the scheduler.
nice -n -15 $BIN/vdisp-reader count map 22 > $WORK/map & MAP=$!
RANDOM=4711
for i in $(seq 100); do
  case $((i % 4)) in
    0) $BIN/vdisp-reader count copy 60 > /dev/null & ;;
    1) $BIN/vdisp-reader sets 9999 > /dev/null & ;;
    2) $BIN/vdisp-planner > /dev/null & ;;
    3) $BIN/vdisp-reader hold left 6 60 > /dev/null & ;;
  esac
  VICTIM=$!
  [ $((i % 5)) = 0 ] && sleep 0.00$((RANDOM % 10)) || sleep 0.0$((RANDOM % 90 + 10))
  kill -9 $VICTIM; wait $VICTIM 2>/dev/null
done
sleep 0.6   # the last one's blocks come back within 0.3 s
# 11 of the 16 blocks of this size can be held, as before the first kill: none was lost with a reader.
$BIN/vdisp-reader hold left 11 4 > $WORK/hold & wait_for $WORK/hold holding
nice -n -15 $BIN/vdisp-reader count left 2 > $WORK/left
wait $MAP
kill -TERM $DAEMON; wait $DAEMON || fail "the daemon ended with $?"
cat $WORK/map $WORK/left $WORK/daemon
steady $WORK/map 1000 "the steady reader was disturbed"
steady $WORK/left 90 "blocks of the dead did not come back"
[ "$(value $WORK/daemon allocations)" = 0 ] || fail "the loop allocated"
echo passed
