#!/usr/bin/python3
"""400: what systemd is told: ready when it is, how the daemon is, alive while the tree steps and a new reader could attach.

SPDX-License-Identifier: Apache-2.0
"""
import ctypes
import os
import pathlib
import re
import signal
import socket
import time
import unittest

from programs import ProgramTest, Running, isolated_main, run, wait_until

SMALL = [word for item in ("sim.width=160", "sim.height=120", "image source.ndisp=32", "sim.rate=30") for word in ("--set", item)]
ATTACH, DETACH = 16, 17
libc = ctypes.CDLL(None, use_errno=True)


def thread_of(pid, name):
    """The number of the thread of this name."""
    for task in pathlib.Path(f"/proc/{pid}/task").iterdir():
        if (task / "comm").read_text().strip() == name:
            return int(task.name)
    raise AssertionError(f"no thread {name} in {[(t / 'comm').read_text().strip() for t in pathlib.Path(f'/proc/{pid}/task').iterdir()]}")


class Hung:
    """One thread stands still, as if it waited for something that never comes; the others go on."""

    def __init__(self, thread):
        self.thread = thread

    def __enter__(self):
        if libc.ptrace(ATTACH, self.thread, None, None) != 0:
            raise unittest.SkipTest("a thread cannot be stopped here: ptrace is not permitted: " + os.strerror(ctypes.get_errno()))
        os.waitpid(self.thread, 0x40000000)  # __WALL
        return self

    def __exit__(self, *_):
        libc.ptrace(DETACH, self.thread, None, None)


class Supervised(Running):
    """The daemon as systemd starts it; what it tells is kept as (time when it was read, line)."""

    def __init__(self, folder, *arguments, watchdog_s=2.0, **options):
        self.place = str(folder / "notify")
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.socket.bind(self.place)
        self.socket.setblocking(False)
        self.told = []
        environment = {**os.environ, "NOTIFY_SOCKET": self.place}
        if watchdog_s:
            environment["WATCHDOG_USEC"] = str(int(watchdog_s * 1e6))
        super().__init__("vdispd", *arguments, env=environment, **options)

    def __exit__(self, *_):
        super().__exit__()
        self.socket.close()
        os.unlink(self.place)

    def listen(self):
        while True:
            try:
                message = self.socket.recv(4096).decode()
            except BlockingIOError:
                return self.told
            self.told += [(time.monotonic(), line) for line in message.splitlines()]

    def lines(self, begin, since=0.0):
        return [line for when, line in self.listen() if line.startswith(begin) and when >= since]

    def hears(self, begin, limit=15.0, since=0.0):
        return wait_until(lambda: self.lines(begin, since), limit)

    def status(self, pattern, limit=15.0, since=0.0):
        return wait_until(lambda: any(re.search(pattern, line) for line in self.lines("STATUS=", since)), limit)


class ServiceTest(ProgramTest):
    def everything(self, daemon):
        return f"{daemon.listen()}\n{daemon.text()}"

    def assert_fed(self, daemon, seconds=5.0):
        daemon.listen()
        self.assertTrue(daemon.hears("WATCHDOG=1", seconds, time.monotonic()), self.everything(daemon))

    def assert_starves(self, daemon):
        """After what may still be under way."""
        time.sleep(3.5)
        daemon.listen()
        since = time.monotonic()
        time.sleep(1.5)
        self.assertEqual(daemon.lines("WATCHDOG=1", since), [])

    def test_ready_after_the_first_good_frame_with_rate_latency_floor_and_camera(self):
        with Supervised(self.folder, "--sim", *SMALL) as daemon:
            self.assertTrue(daemon.hears("READY=1"), daemon.text())
            good = r"STATUS=\d+\.\d Hz, map \d+\.\d ms after the frame, floor 0\.[78]\d m below, pitch 1[45]\.\d deg, frames of no camera$"
            self.assertTrue(daemon.status(good), self.everything(daemon))
            daemon.listen()
            since = time.monotonic()
            time.sleep(3)
            self.assertIn(len(daemon.lines("STATUS=", since)), (2, 3, 4), self.everything(daemon))
            self.assertEqual(len(daemon.lines("READY=1")), 1)
            daemon.process.send_signal(signal.SIGTERM)
            self.assertEqual(daemon.process.wait(20), 0)
            self.assertTrue(daemon.hears("STOPPING=1", 1))

    def test_ready_with_a_camera_that_is_named_and_absent_and_the_status_says_so(self):
        sets = ("--set", "image source.source=v4l2", "--set", "camera.left=/dev/video77", "--set", "camera.right=/dev/video78",
                "--set", "image source.width=160", "--set", "image source.height=120", "--set", "image source.ndisp=32")
        with Supervised(self.folder, *sets) as daemon:
            self.assertTrue(daemon.status(r"STATUS=camera absent, blind at \d+\.\d Hz: .*video77"), self.everything(daemon))
            self.assertEqual(len(daemon.lines("READY=1")), 1)
            self.assert_fed(daemon)  # blind steps are steps

    def test_frames_that_are_all_bad_are_ready_after_a_while(self):
        folder = self.write_pairs(2)
        (folder / "left/000001.png").write_bytes(b"no image")
        (folder / "left/000000.png").rename(folder / "left/000002.png")
        (folder / "right/000000.png").rename(folder / "right/000002.png")
        (folder / "left/000003.png").write_bytes(b"no image")
        (folder / "right/000003.png").write_bytes(b"no image")
        # The one good pair tells the size, and comes 8 s after the first.
        config = self.write_config("rate=0.125\nloop=yes\n", middleware="none")
        with Supervised(self.folder, "-c", config) as daemon:
            begin = time.monotonic()
            self.assertTrue(daemon.hears("READY=1", 12), self.everything(daemon))
            self.assertGreater(time.monotonic() - begin, 4)
            self.assertTrue(daemon.status("STATUS=blind at .*000001.png"), self.everything(daemon))

    def test_nothing_is_said_of_good_frames_before_there_is_one(self):
        with Supervised(self.folder, "--set", "image source.source=auto") as daemon:
            self.assertEqual(daemon.process.wait(30), 69)
            self.assertEqual(daemon.lines("READY=1"), [])

    def test_the_watchdog_starves_while_the_loop_hangs_and_is_fed_when_it_goes_on(self):
        with Supervised(self.folder, "--sim", *SMALL) as daemon:
            self.assertTrue(daemon.hears("READY=1"), daemon.text())
            self.assert_fed(daemon)
            with Hung(daemon.process.pid):
                self.assert_starves(daemon)
            self.assert_fed(daemon)

    def test_the_watchdog_starves_when_no_new_reader_can_attach(self):
        for thread in ("IPC-msg-process", "Mon+Discover"):
            with self.subTest(thread=thread), Supervised(self.folder, "--sim", *SMALL) as daemon:
                self.assertTrue(daemon.hears("READY=1"), daemon.text())
                self.assert_fed(daemon)
                with Hung(thread_of(daemon.process.pid, thread)):
                    self.assertTrue(daemon.status("STATUS=no new reader can attach; .* Hz"), self.everything(daemon))
                    self.assert_starves(daemon)
                    self.assertTrue(wait_until(lambda: "no new reader can attach" in daemon.text()), daemon.text())
                self.assert_fed(daemon)
                self.assertTrue(wait_until(lambda: "can attach again" in daemon.text()), daemon.text())

    def test_the_watchdog_starves_when_the_socket_of_new_readers_is_removed(self):
        with Supervised(self.folder, "--sim", *SMALL) as daemon:
            self.assertTrue(daemon.hears("READY=1"), daemon.text())
            self.assert_fed(daemon)
            os.unlink("/tmp/roudi")
            self.assert_starves(daemon)
            self.assertNotEqual(run("vdisp-probe", "list").returncode, 0)  # it is true

    def test_a_watchdog_that_kills_brings_back_a_daemon_that_a_reader_finds(self):
        with Supervised(self.folder, "--sim", *SMALL) as daemon:
            self.assertTrue(daemon.hears("READY=1"), daemon.text())
            with Hung(daemon.process.pid):
                self.assert_starves(daemon)
                os.kill(daemon.process.pid, signal.SIGKILL)
            daemon.process.wait(10)
        time.sleep(0.1)  # RestartSec at the least
        with Supervised(self.folder, "--sim", *SMALL) as daemon:
            self.assertTrue(daemon.hears("READY=1"), daemon.text())
            self.assertTrue(wait_until(lambda: run("vdisp-probe", "list").returncode == 0, 5))

    def test_rare_steps_stretch_the_watchdog(self):
        with Supervised(self.folder, "--sim", *SMALL, "--set", "main.period=3000") as daemon:
            self.assertTrue(daemon.hears("WATCHDOG_USEC=9000000"), self.everything(daemon))
            self.assertEqual(run("vdisp-probe", "set", "period", "0").returncode, 0)
            self.assertTrue(daemon.hears("WATCHDOG_USEC=2000000"), self.everything(daemon))

    def test_without_systemd_nothing_runs_for_it(self):
        environment = {key: value for key, value in os.environ.items() if key != "NOTIFY_SOCKET"}
        with Running("vdispd", "--sim", *SMALL, env=environment) as daemon:
            self.assertTrue(wait_until(lambda: "ready" in daemon.text()), daemon.text())
            self.assertRaises(AssertionError, thread_of, daemon.process.pid, "service")

    def test_a_systemd_that_is_gone_is_one_line(self):
        environment = {**os.environ, "NOTIFY_SOCKET": str(self.folder / "nobody")}
        with Running("vdispd", "--sim", *SMALL, env=environment) as daemon:
            self.assertTrue(wait_until(lambda: "NOTIFY_SOCKET" in daemon.text()), daemon.text())
            time.sleep(2)
            self.assertEqual(daemon.text().count("NOTIFY_SOCKET"), 1)
            self.assertIsNone(daemon.process.poll())


if __name__ == "__main__":
    isolated_main()
