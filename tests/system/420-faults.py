#!/usr/bin/python3
"""420: what goes wrong around the daemon: memory, readers, senders, clock, a second daemon, and its own end at any moment. docs/faults.md has
the table of all faults, and which test proves each.

    420-faults.py [SECONDS]    a reader is stopped for so long (5)
SPDX-License-Identifier: Apache-2.0
"""
import fcntl
import grp
import importlib
import os
import pwd
import random
import resource
import shutil
import signal
import socket
import subprocess
import sys
import time
import unittest.mock

from faults import FaultTest, Steady, SteppedClock, hasten, mount
from programs import BIN, Running, isolated_main, run, wait_until

control = importlib.import_module("070-control")
STOPPED_S = 5.0
HOUR = 3600


class Memory(FaultTest):
    def test_shared_memory_that_is_too_small_ends_the_start_with_71_and_leaves_nothing(self):
        mount(self, "/dev/shm", "40m")
        self.assert_refused(run("vdispd", "--sim", *self.small), 71, "/dev/shm has 40 MiB free", "needed are", "mount it larger")
        self.assertEqual(os.listdir("/dev/shm"), [])

    def test_shared_memory_that_others_fill_later_costs_neither_a_frame_nor_a_new_reader(self):
        mount(self, "/dev/shm", "200m")
        self.start()
        with open("/dev/shm/filler", "wb", buffering=0) as filler:
            self.assertRaises(OSError, lambda: [filler.write(bytes(1 << 20)) for _ in range(300)])
        steady = Steady(2)
        self.assertEqual(self.frames_of_a_new_reader(), 5)
        self.assertEqual(steady.missed(), 0)
        self.assertEqual(self.health()["drops"], 0)

    def test_a_client_without_memory_says_so_with_71_wherever_it_runs_out(self):
        self.start()
        starts = self.least_memory(0, 1 << 20, lambda size: run("vdisp-probe", "--version", preexec_fn=self.limit(size)).returncode == 0)
        seen = set()

        def sees_all_stages(size):
            result = run("vdisp-probe", "sheet", self.folder / "sheet.png", preexec_fn=self.limit(size))
            if result.returncode:
                self.assert_refused(result, 71, "emory")
                seen.add(result.stderr)
            return result.returncode == 0
        enough = self.least_memory(starts, 1 << 16, sees_all_stages)  # what the linker says with less than starts is not ours
        for size in range(starts, enough, (enough - starts) // 12):
            sees_all_stages(size)
        print(f"vdisp-probe sheet needs {enough >> 10} kB; with less:", *sorted(seen), sep="\n")
        for where in ("iceoryx's management memory", "/dev/shm/", "not enough memory"):
            self.assertTrue(any(where in line for line in seen), seen)
        self.assertEqual(self.frames_of_a_new_reader(), 5)

    def test_a_motor_link_without_memory_ends_with_71(self):
        starts = self.least_memory(0, 1 << 18, lambda size: run("vdisp-drive", "--version", preexec_fn=self.limit(size)).returncode == 0)
        self.assert_refused(run("vdisp-drive", "--port", "-", preexec_fn=self.limit(starts + (1 << 20))), 71, "not enough memory")

    def least_memory(self, too_little, step, enough):
        """The least that is enough, to within a step."""
        plenty = 4 << 30
        while plenty - too_little > step:
            middle = (too_little + plenty) // 2
            too_little, plenty = (too_little, middle) if enough(middle) else (middle, plenty)
        return plenty

    def test_a_planner_without_memory_is_told_why_and_goes_on_when_there_is_some(self):
        self.start()
        with open(self.folder / "said", "w") as said, Running("vdisp-planner", stdout=said, preexec_fn=self.limit(64 << 20)) as planner:
            text = (self.folder / "said").read_text
            self.assertTrue(wait_until(lambda: "dead: cannot map" in text()), text() + planner.text())
            self.assertIn("memory: Cannot allocate memory", text())
            resource.prlimit(planner.process.pid, resource.RLIMIT_AS, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
            self.assertTrue(wait_until(lambda: "\nfresh" in text()), text())

    def limit(self, size):
        return lambda: resource.setrlimit(resource.RLIMIT_AS, (size, resource.RLIM_INFINITY))


class Readers(FaultTest):
    def test_readers_that_were_stopped_for_long_go_on_and_have_cost_nobody_a_frame(self):
        self.start()
        said = self.folder / "said"
        with open(said, "a") as file, Running("vdisp-probe", "map", "--json", stdout=file) as one, \
             Running("vdisp-probe", "dump", self.folder / "dump", "--frames", "1000000", stdout=subprocess.DEVNULL) as all_stages:
            fresh = lambda: '"state":"fresh"' in said.read_text()
            frames = lambda: len(list((self.folder / "dump").glob("0*")))
            self.assertTrue(wait_until(lambda: fresh() and frames() > 3), one.text() + all_stages.text())
            for reader in (one, all_stages):
                reader.process.send_signal(signal.SIGSTOP)
            time.sleep(0.2)
            before = frames()
            steady = Steady(STOPPED_S)
            self.assertEqual(steady.missed(), 0)
            self.assertEqual(self.health()["drops"], 0, "a stopped reader holds two images of a topic, no more")
            os.truncate(said, 0)
            for reader in (one, all_stages):
                reader.process.send_signal(signal.SIGCONT)
            self.assertTrue(wait_until(lambda: fresh() and frames() > before + 3), said.read_text()[-300:] + all_stages.text())

    def test_readers_cannot_write_an_image_and_outsiders_are_told_77_whatever_their_clock_says(self):
        group, nobody = grp.getgrnam("daemon").gr_gid, pwd.getpwnam("nobody").pw_uid
        self.start("--set", "ipc.group=daemon", extra_groups=[group])
        time.sleep(2)  # an outsider is told nothing while the daemon may still be starting
        shutil.copy(BIN / "vdisp-reader", self.folder)
        os.chmod(self.folder, 0o755)
        clock = SteppedClock(self.folder)

        def reader(*words, groups=(), **options):
            return subprocess.run([self.folder / "vdisp-reader", *words], capture_output=True, text=True, user=nobody, group=nobody,
                                  extra_groups=groups, **options)
        steady = Steady(2.5)
        for _ in range(3):
            self.assertEqual(reader("write", groups=[group]).returncode, -signal.SIGSEGV)
        self.assertEqual(reader("connect", "1", groups=[group]).returncode, 0)
        self.assertEqual([name for name in os.listdir("/dev/shm") if name != "iceoryx_mgmt"
                          and subprocess.run(["sh", "-c", f": 3<> /dev/shm/{name}"], stderr=subprocess.DEVNULL, user=nobody, group=nobody,
                                             extra_groups=[group]).returncode == 0], [])
        for hours in (0, -1):
            clock.set(hours * HOUR)
            refused = reader("connect", "1", env=clock.environment)
            self.assertEqual(refused.returncode, 77, refused.stdout)
            self.assertIn("member of group daemon", refused.stdout)
        self.assertEqual(steady.missed(), 0)


class Senders(FaultTest):
    def full_speed(self, kind):
        """A process that sends on the control socket, as fast as it can, until it is killed."""
        pid = os.fork()
        if pid:
            return pid
        while True:
            try:
                with control.connected() as client:
                    while True:
                        client.send({"odometry": lambda: control.odometry(0), "deaf": lambda: control.parameter(control.GET, "thresh"),
                                     "rubbish": lambda: os.urandom(random.randrange(1, 4000))}[kind]())
            except OSError:
                pass
            except BaseException:
                os._exit(1)

    def test_100_senders_killed_at_full_speed_some_with_rubbish_leave_a_daemon_that_new_readers_find(self):
        daemon = self.start()
        descriptors = lambda: len(os.listdir(f"/proc/{daemon.process.pid}/fd"))
        before = descriptors()
        steady = Steady(5)
        for number in range(100):
            victim = self.full_speed(("odometry", "deaf", "rubbish")[number % 3])
            time.sleep(random.uniform(0.005, 0.06))
            os.kill(victim, signal.SIGKILL)
            os.waitpid(victim, 0)
        self.assertEqual(self.frames_of_a_new_reader(), 5)
        self.assertEqual(run("vdisp-probe", "set", "thresh", "11").returncode, 0)
        self.assertEqual(steady.missed(), 0)
        told = self.health()
        print(told["control"], told["inputs"]["odometry"], len(daemon.text().splitlines()), "lines")
        self.assertGreater(told["inputs"]["odometry"]["accepted"], 100)
        self.assertGreater(told["control"]["connections_closed"], 30)
        self.assertTrue(wait_until(lambda: descriptors() <= before), descriptors())
        self.assertLess(len(daemon.text().splitlines()), 300, "a line on the edge, not for each message")


class Clock(FaultTest):
    def test_a_wall_clock_that_is_stepped_costs_nothing_and_nobody(self):
        clock = SteppedClock(self.folder)
        service = importlib.import_module("400-service")
        with unittest.mock.patch.dict(os.environ, clock.preloaded):
            daemon = service.Supervised(self.folder, "--sim", *self.small, stdout=subprocess.DEVNULL, preexec_fn=hasten)
        with daemon:
            self.assertTrue(daemon.hears("READY=1"), daemon.text())
            for hours in (1, -24 * 365):
                steady = Steady(2, env=clock.environment)
                time.sleep(0.3)
                clock.step(hours * HOUR)
                with Running("vdisp-reader", "hold", "left", "3", "60", stdout=subprocess.DEVNULL) as victim:  # is noticed to be dead
                    time.sleep(0.5)
                    victim.process.kill()
                self.assertEqual(self.frames_of_a_new_reader(env=clock.environment), 5)
                self.assertEqual(steady.missed(), 0, f"{hours} h")
                since = time.monotonic()
                self.assertTrue(wait_until(lambda: daemon.lines("WATCHDOG=1", since), 5), f"{hours} h: {daemon.told[-5:]} {daemon.text()}")
            told = self.health()
            self.assertEqual((told["drops"], told["blind_frames"]), (0, 0))
            self.assertLess(told["latency"]["max_ms"], 2000)
            self.assertNotIn("no new reader", daemon.text())

    def test_a_daemon_that_starts_with_an_earlier_clock_is_read_anew(self):
        clock = SteppedClock(self.folder)
        with open(self.folder / "said", "w") as said, Running("vdisp-planner", stdout=said):
            text = (self.folder / "said").read_text
            for number, hours in enumerate((0, -24)):
                clock.set(hours * HOUR)
                daemon = self.start(extra_env=clock.preloaded)
                self.assertTrue(wait_until(lambda: text().count("\nfresh") == number + 1, 5), text())
                daemon.process.kill()
                daemon.process.wait()
                self.assertTrue(wait_until(lambda: text().count("dead") == number + 2), text())  # dead before the first, too
            self.assertEqual(text().count("reading everything anew"), 2, text())


class Ends(FaultTest):
    def test_a_second_daemon_is_refused_with_69_and_the_first_does_not_notice(self):
        first = self.start()
        steady = Steady(2.5)
        for _ in range(3):
            self.assert_refused(run("vdispd", "--sim", *self.small), 69, f"vdispd, pid {first.process.pid}", "one vdispd per machine")
        self.assertEqual(self.frames_of_a_new_reader(), 5)
        self.assertEqual(run("vdisp-probe", "set", "thresh", "11").returncode, 0)
        self.assertEqual(steady.missed(), 0)

    def test_a_second_daemon_names_the_first_and_nobody_with_a_lock_elsewhere(self):
        first = self.start()
        wanted = os.stat("/tmp/iox-unique-roudi.lock").st_ino
        (self.folder / "other").mkdir()
        mount(self, self.folder / "other")
        files = (self.folder / "other" / str(number) for number in range(10000))
        same = next((file for file in files if file.touch() or file.stat().st_ino == wanted), None)  # numbers begin anew in each tmpfs
        if not same:
            self.skipTest(f"no file of number {wanted} can be made here")
        everywhere = os.sched_getaffinity(0)
        with open(same) as file:
            os.sched_setaffinity(0, {min(everywhere)})  # the kernel tells of this processor's locks first
            fcntl.flock(file, fcntl.LOCK_EX)
            os.sched_setaffinity(0, everywhere)
            self.assert_refused(run("vdispd", "--sim", *self.small), 69, f"vdispd, pid {first.process.pid}")

    def test_killed_at_any_moment_of_its_start_the_next_one_is_read_within_1_s(self):
        with open(self.folder / "said", "w") as said, Running("vdisp-planner", stdout=said) as planner:
            for number in range(10):
                with Running("vdispd", "--sim", *self.small, stdout=subprocess.DEVNULL):
                    time.sleep(0.04 * number)
            slowest = 0.0
            for _ in range(3):
                with open(said.name, "r+") as old:
                    old.truncate(0)
                daemon = self.start()
                ready = time.monotonic()
                self.assertTrue(wait_until(lambda: "fresh" in (self.folder / "said").read_text(), 5), daemon.text())
                slowest = max(slowest, time.monotonic() - ready)
                time.sleep(random.uniform(0, 0.3))
                daemon.process.kill()
                daemon.process.wait()
                self.assertIsNone(planner.process.poll(), planner.text())
                self.assertTrue(wait_until(lambda: "dead" in (self.folder / "said").read_text().split("fresh")[-1]), "not dead")
            print(f"fresh at most {slowest:.3f} s after ready")
            self.assertLess(slowest, 1)


if __name__ == "__main__":
    if len(sys.argv) > 1 and sys.argv[1].isdigit():
        os.environ["VDISP_STOPPED_S"] = sys.argv.pop(1)
    STOPPED_S = float(os.environ.get("VDISP_STOPPED_S", STOPPED_S))
    isolated_main()
