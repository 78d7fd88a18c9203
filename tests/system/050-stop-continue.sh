# 050-stop-continue: readers and the daemon are stopped for seconds and continue; all recover. Second argument: rounds of 10 readers each.
# SPDX-License-Identifier: Apache-2.0
. "$(dirname "$0")/private.sh"
ROUNDS=${2:-1}
$BIN/vdisp-publish --rate 30 > $WORK/daemon & DAEMON=$!; wait_for $WORK/daemon ready
nice -n -15 $BIN/vdisp-reader count map $((ROUNDS * 6 + 2)) > $WORK/steady & STEADY=$!
readers=()
for i in $(seq 10); do $BIN/vdisp-planner > $WORK/reader$i & readers+=($!); done
sleep 0.5
for round in $(seq $ROUNDS); do
  for i in $(seq 10); do
    ( sleep 0.$((RANDOM % 9)); kill -STOP ${readers[$((i - 1))]}; sleep $((RANDOM % 3 + 2)).$((RANDOM % 10)); kill -CONT ${readers[$((i - 1))]} ) & pids[$i]=$!
  done
  wait "${pids[@]}"
  for i in $(seq 10); do : > $WORK/reader$i; done
  sleep 0.7
  for i in $(seq 10); do
    kill -0 ${readers[$((i - 1))]} || fail "round $round: reader $i has ended"
    grep -q "^map" $WORK/reader$i || fail "round $round: reader $i reads nothing: $(cat $WORK/reader$i)"
  done
done
wait $STEADY
cat $WORK/steady
[ "$(value $WORK/steady missed)" = 0 ] || fail "a stopped reader disturbed another"
# the daemon stops: dead after 1 s without heartbeat; and continues
$BIN/vdisp-reader watch 6 > $WORK/watch & WATCH=$!; wait_for $WORK/watch fresh
kill -STOP $DAEMON; wait_for $WORK/watch dead; sleep 1.5; kill -CONT $DAEMON
wait $WATCH
cut -d' ' -f1 $WORK/watch | tr '\n' ' ' | grep -q "fresh stale dead.* fresh" || fail "stopped daemon: $(cat $WORK/watch)"
# stopped while the daemon is killed and a new one starts
kill -STOP ${readers[0]}; kill -9 $DAEMON; wait $DAEMON 2>/dev/null
$BIN/vdisp-publish --rate 30 > $WORK/daemon & DAEMON=$!; wait_for $WORK/daemon ready
sleep 1; : > $WORK/reader1; kill -CONT ${readers[0]}; sleep 1
grep -q "^map" $WORK/reader1 || fail "stopped over a restart: $(cat $WORK/reader1)"
kill -TERM $DAEMON; wait $DAEMON || fail "the daemon ended with $?"
echo "$((ROUNDS * 10)) stops of 2 to 5 s"
echo passed
