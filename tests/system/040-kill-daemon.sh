# 040-kill-daemon: the daemon is killed 20 times; the planner says dead, reads fresh maps within 1 s of the next one being ready, and lives on.
# SPDX-License-Identifier: Apache-2.0
. "$(dirname "$0")/private.sh"
stamped() { while IFS= read -r line; do echo "${EPOCHREALTIME/./} $line"; done; }
$BIN/vdisp-planner > >(stamped > $WORK/planner) & PLANNER=$!
wait_for $WORK/planner " dead"
worst=0
for i in $(seq 20); do
  $BIN/vdisp-publish --rate 30 > >(stamped > $WORK/daemon) & DAEMON=$!
  wait_for $WORK/daemon ready
  for _ in $(seq 60); do [ "$(grep -c ' fresh' $WORK/planner)" -ge $i ] && break; sleep 0.05; done
  [ "$(grep -c ' fresh' $WORK/planner)" = $i ] || fail "round $i: not fresh: $(tail -3 $WORK/planner)"
  took=$(( $(grep ' fresh' $WORK/planner | tail -1 | cut -d' ' -f1) - $(cut -d' ' -f1 $WORK/daemon | head -1) ))
  [ $took -gt $worst ] && worst=$took
  sleep 0.$((RANDOM % 5))
  kill -9 $DAEMON; wait $DAEMON 2>/dev/null
  for _ in $(seq 60); do [ "$(grep -c ' dead' $WORK/planner)" -gt $i ] && break; sleep 0.05; done
  [ "$(grep -c ' dead' $WORK/planner)" = $((i + 1)) ] || fail "round $i: not dead: $(tail -3 $WORK/planner)"
  kill -0 $PLANNER || fail "round $i: the planner has ended"
done
[ "$(grep -c 'reading everything anew' $WORK/planner)" = 20 ] || fail "epochs: $(grep -c anew $WORK/planner)"
echo "slowest: fresh $worst us after ready (negative: the first image came before the daemon said so)"
[ $worst -lt 1000000 ] || fail "slower than 1 s"
[ "$(grep -c iceoryx_mgmt /proc/$PLANNER/maps)" = 0 ] || fail "memory of dead daemons is still mapped"
echo passed
