# 050-stop-continue: planners, vdisp-probe and vdispd are stopped for seconds and continue; all recover. Second argument: rounds of 10 readers each.
# SPDX-License-Identifier: Apache-2.0
. "$(dirname "$0")/private.sh"
ROUNDS=${2:-1}
nice -n -15 "${DAEMON[@]}" 2> $WORK/daemon & PID=$!; wait_for $WORK/daemon "$READY"
nice -n -15 $BIN/vdisp-reader count map $((ROUNDS * 6 + 3)) > $WORK/steady & STEADY=$!
readers=()
for i in $(seq 10); do
  case $((i % 3)) in
    0) $BIN/vdisp-probe map --json > $WORK/reader$i & ;;
    1) $BIN/vdisp-planner > $WORK/reader$i & ;;
    2) $BIN/vdisp-probe stats --json > $WORK/reader$i & ;;
  esac
  readers[$i]=$!
done
reads() { # I: that reader tells something new and good, at most 3 s from now
  : > $WORK/reader$1
  for _ in $(seq 60); do grep -qE '^map |"state":"(fresh|running)"' $WORK/reader$1 && return 0; sleep 0.05; done
  fail "reader $1 reads nothing: $(cut -c 1-300 $WORK/reader$1)"
}
for i in $(seq 10); do reads $i; done
for round in $(seq $ROUNDS); do
  for i in $(seq 10); do
    ( sleep 0.$((RANDOM % 9)); kill -STOP ${readers[$i]}; sleep $((RANDOM % 3 + 2)).$((RANDOM % 10)); kill -CONT ${readers[$i]} ) & pids[$i]=$!
  done
  wait "${pids[@]}"
  for i in $(seq 10); do
    kill -0 ${readers[$i]} || fail "round $round: reader $i has ended"
    reads $i
  done
done
wait $STEADY
cat $WORK/steady
steady $WORK/steady 1 "a stopped reader disturbed another"
# the daemon stops: dead after 1 s without heartbeat; and continues
$BIN/vdisp-reader watch 6 > $WORK/watch & WATCH=$!; wait_for $WORK/watch fresh
kill -STOP $PID; wait_for $WORK/watch dead; sleep 1.5; kill -CONT $PID
wait $WATCH
cut -d' ' -f1 $WORK/watch | tr '\n' ' ' | grep -q "fresh stale dead.* fresh" || fail "stopped daemon: $(cat $WORK/watch)"
for i in $(seq 10); do reads $i; done
# stopped while the daemon is killed and a new one starts
for i in 1 2 3; do kill -STOP ${readers[$i]}; done
kill -9 $PID; wait $PID 2>/dev/null
nice -n -15 "${DAEMON[@]}" 2> $WORK/daemon & PID=$!; wait_for $WORK/daemon "$READY"
sleep 1
for i in 1 2 3; do kill -CONT ${readers[$i]}; reads $i; done
kill -TERM $PID; wait $PID || fail "the daemon ended with $?"
echo "$((ROUNDS * 10)) stops of 2 to 5 s"
echo passed
