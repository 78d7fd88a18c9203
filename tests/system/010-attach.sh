# 010-attach: readers attach before, during and after the daemon; sets are of one frame; nothing hangs or aborts.
# SPDX-License-Identifier: Apache-2.0
. "$(dirname "$0")/private.sh"
$BIN/vdisp-reader connect 0.3 > $WORK/none; [ $? = 69 ] || fail "no daemon: exit code, $(cat $WORK/none)"
$BIN/vdisp-client-c || fail "C client without a daemon"
$BIN/vdisp-reader watch 4 > $WORK/early &
$BIN/vdisp-publish --rate 100 --frames 600 > $WORK/daemon & wait_for $WORK/daemon ready
$BIN/vdisp-reader connect 1 || fail "does not connect"
$BIN/vdisp-reader sets 200 || fail "sets"
$BIN/vdisp-client-c attached || fail "C client"
$BIN/vdisp-planner --frames 50 > $WORK/planner || fail "planner ends with $?"
grep -q "^map .*synthetic.*nearest obstacle" $WORK/planner || fail "planner: $(cat $WORK/planner)"
wait %3 2>/dev/null; wait
grep -q "drops 0 allocations 0" $WORK/daemon || fail "the daemon's loop: $(cat $WORK/daemon)"
head -2 $WORK/early | tail -1 | grep -q fresh && head -1 $WORK/early | grep -q dead || fail "early reader: $(cat $WORK/early)"
[ -z "$(ls /dev/shm)" ] || fail "left in /dev/shm: $(ls /dev/shm)"
# blind is not fresh, and not dead
$BIN/vdisp-publish --rate 50 --frames 100 --blind > $WORK/daemon & wait_for $WORK/daemon ready
$BIN/vdisp-reader watch 1 > $WORK/blind
grep -q blind $WORK/blind && ! grep -q fresh $WORK/blind || fail "blind: $(cat $WORK/blind)"
wait
# a program that serves RouDi's socket and never answers
$BIN/vdisp-reader impostor 3 & sleep 0.2
$BIN/vdisp-reader connect 1.5 > $WORK/mute; [ $? = 69 ] || fail "impostor: $(cat $WORK/mute)"
grep -q "does not answer" $WORK/mute || fail "impostor: $(cat $WORK/mute)"
cat $WORK/mute
wait
echo passed
