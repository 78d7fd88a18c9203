# 020-slow-reader: a reader that never gives an image back starves its own pool; the map goes on, drops are counted, nothing allocates.
# SPDX-License-Identifier: Apache-2.0
. "$(dirname "$0")/private.sh"
nice -n -15 $BIN/vdisp-publish --rate 50 --frames 450 > $WORK/daemon & DAEMON=$!; wait_for $WORK/daemon ready
nice -n -15 $BIN/vdisp-reader count map 5 > $WORK/map & MAP=$!
$BIN/vdisp-reader hold left 24 1 > $WORK/hold & HOLD=$!; wait_for $WORK/hold holding
wait $HOLD
$BIN/vdisp-reader count left 2 > $WORK/left   # its blocks are back
wait $MAP $DAEMON
cat $WORK/map $WORK/left $WORK/daemon
steady $WORK/map 220 "the map was disturbed"
[ "$(value $WORK/left frames)" -ge 75 ] || fail "the blocks did not come back"
[ "$(value $WORK/daemon drops)" -ge 30 ] || fail "drops were not counted"
[ "$(value $WORK/daemon allocations)" = 0 ] || fail "the loop allocated"
echo passed
