# 030-kill-readers: vdisp-probe and planners are killed at 100 random moments, also while they attach; a steady reader of the daemon misses no frame.
# SPDX-License-Identifier: Apache-2.0
. "$(dirname "$0")/private.sh"
nice -n -15 "${DAEMON[@]}" 2> $WORK/daemon & PID=$!; wait_for $WORK/daemon "$READY"
# Before the crowd in the queue for the processor: what is tested is the memory, not the scheduler.
nice -n -15 $BIN/vdisp-reader count map 33 > $WORK/map & MAP=$!
RANDOM=4711
for i in $(seq 100); do
  case $((i % 5)) in
    0) $BIN/vdisp-probe dump $WORK/dump$i --frames 100000 > /dev/null & ;;
    1) $BIN/vdisp-probe map --json >> $WORK/json & ;;
    2) $BIN/vdisp-probe list > /dev/null & ;;
    3) $BIN/vdisp-probe stats --json > /dev/null & ;;
    4) $BIN/vdisp-planner > /dev/null & ;;
  esac
  VICTIM=$!
  [ $((i % 3)) = 0 ] && sleep 0.0$((RANDOM % 90 + 10)) || sleep 0.$((RANDOM % 300 + 100))
  kill -9 $VICTIM 2>/dev/null; wait $VICTIM 2>/dev/null   # a list may have ended
  rm -rf $WORK/dump*
done
[ -s $WORK/json ] || fail "no victim ever read a map"
sleep 0.6   # the last one's blocks come back within 0.3 s
$BIN/vdisp-probe dump $WORK/after --frames 10 || fail "a dump after all the kills: $?"
$BIN/vdisp-probe stats --once --json > $WORK/stats || fail "stats after all the kills: $?"
wait $MAP
kill -TERM $PID; wait $PID || fail "the daemon ended with $?"
cat $WORK/map
steady $WORK/map 850 "the steady reader was disturbed"
# 80 victims held images, often of all stages: blocks lost with them would be missing by now.
! grep -q '"drops":[1-9]' $WORK/stats || fail "images were dropped: $(cat $WORK/stats)"
echo passed
