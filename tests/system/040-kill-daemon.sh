# 040-kill-daemon: vdispd is killed 20 times; the planner says dead, reads fresh maps within 1 s of the next one being ready, and lives on.
# SPDX-License-Identifier: Apache-2.0
. "$(dirname "$0")/private.sh"
$BIN/vdisp-planner > >(stamped > $WORK/planner) & PLANNER=$!
wait_for $WORK/planner " dead"
times() { grep -c " $1" $WORK/planner; }
reaches() { # WORD TIMES: at most 3 s
  for _ in $(seq 60); do [ "$(times $1)" -ge $2 ] && return 0; sleep 0.05; done
  fail "round $i: not $1: $(tail -3 $WORK/planner)"
}
worst=-1000000
for i in $(seq 20); do
  "${DAEMON[@]}" 2> >(stamped > $WORK/daemon) & PID=$!
  wait_for $WORK/daemon "$READY"
  reaches fresh $i
  took=$(( $(grep ' fresh' $WORK/planner | sed -n ${i}p | cut -d' ' -f1) - $(grep "$READY" $WORK/daemon | head -1 | cut -d' ' -f1) ))
  [ $took -gt $worst ] && worst=$took
  sleep 0.$((RANDOM % 5))
  kill -9 $PID; wait $PID 2>/dev/null
  reaches dead $((i + 1))
  kill -0 $PLANNER || fail "round $i: the planner has ended"
  # What a round may say: dead, one start anew, blind while there is no floor yet, fresh; it never says stale or anew for a daemon that is well.
  [ "$(times fresh)" = $i ] && [ "$(times dead)" = $((i + 1)) ] || fail "round $i: not one fresh and one dead: $(cat $WORK/planner)"
done
[ "$(times 'epoch .*reading everything anew')" = 20 ] || fail "epochs: $(times 'epoch')"
echo "slowest: fresh $worst us after ready (negative: the first image came before the daemon said so)"
[ $worst -lt 1000000 ] || fail "slower than 1 s"
[ "$(grep -c iceoryx_mgmt /proc/$PLANNER/maps)" = 0 ] || fail "memory of dead daemons is still mapped"
echo passed
