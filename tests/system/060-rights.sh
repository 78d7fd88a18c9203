# 060-rights: the daemon as a user of its own; members of a group read and cannot write; others get one line.
# SPDX-License-Identifier: Apache-2.0
. "$(dirname "$0")/private.sh"
# the user database is private too
mkdir $WORK/etc; cp -a /etc/passwd /etc/group $WORK/etc
for f in passwd group; do mount --bind $WORK/etc/$f /etc/$f || exit 77; done
for u in 7001:tdaemon 7002:tmember 7003:toutsider; do
  echo "${u#*:}:x:${u%:*}:${u%:*}::/:/bin/sh" >> /etc/passwd; echo "${u#*:}:x:${u%:*}:" >> /etc/group
done
echo "treaders:x:7100:tdaemon,tmember" >> /etc/group
as() { setpriv --reuid $1 --regid $1 --init-groups "${@:2}"; }
check_readers() {
  as tmember $BIN/vdisp-reader connect 1 || fail "a member does not connect"
  as tmember $BIN/vdisp-reader sets 30 || fail "a member does not read"
  as tmember $BIN/vdisp-reader write 2>/dev/null; [ $? = 139 ] || fail "a member's write did not fault"
  as toutsider $BIN/vdisp-reader connect 3 > $WORK/out; [ $? = 77 ] || fail "an outsider: $(cat $WORK/out)"
  grep "member of group treaders" $WORK/out || fail "an outsider: $(cat $WORK/out)"
  $BIN/vdisp-reader connect 1 || fail "root does not connect"
  as tmember sh -c ": 3<> /dev/shm/$1" 2>/dev/null && fail "a member may open the images for writing"
  as toutsider sh -c ": 3< /dev/shm/$1" 2>/dev/null && fail "an outsider may open the images"
  as toutsider sh -c ": 3< /dev/shm/iceoryx_mgmt" 2>/dev/null && fail "an outsider may open the management memory"
  true
}
for user in tdaemon root; do
  as $user $BIN/vdisp-publish --group treaders --rate 50 > $WORK/daemon & wait_for $WORK/daemon ready
  sleep 2   # an outsider is told nothing while the daemon may still be starting
  check_readers $user
  kill -TERM $(value $WORK/daemon pid); wait
done
as tdaemon $BIN/vdisp-publish --rate 50 > $WORK/daemon & wait_for $WORK/daemon ready
as tdaemon $BIN/vdisp-reader connect 1 || fail "the same user does not connect"
as tmember $BIN/vdisp-reader connect 3 > $WORK/out; [ $? = 77 ] && grep "only its own user tdaemon" $WORK/out || fail "without a group: $(cat $WORK/out)"
kill -TERM $(value $WORK/daemon pid); wait
as toutsider $BIN/vdisp-publish --group treaders --frames 1 2> $WORK/out; [ $? = 77 ] && grep "not a member" $WORK/out || fail "not a member: $(cat $WORK/out)"
echo passed
