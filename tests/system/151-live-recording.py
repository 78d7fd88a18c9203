#!/usr/bin/python3
"""151: recordings of what comes at a pace of its own: inputs, orders, a hand at the window, cameras. Replayed to the same stages bit by bit.

SPDX-License-Identifier: Apache-2.0
"""
import json
import os
import shutil
import subprocess
import threading
import time
import unittest

import cv2
import numpy

import gige
from gige import GigeCamera
from programs import BIN, Running, isolated_main, run, wait_until
from recordings import RecordingTest, sets


class Live(RecordingTest):
    def test_a_run_with_inputs_is_replayed_to_the_same_stages_bit_by_bit(self):
        stop = threading.Event()
        with Running("vdispd", "--sim", *sets("sim.rate=10"), "--frames", 60, "--dump", self.folder / "live", "--record", self.folder / "drive",
                     stdout=subprocess.DEVNULL) as daemon:
            threads = self.feed(stop)
            self.assertEqual(daemon.process.wait(120), 0, daemon.text())
            stop.set()
            for thread in threads:
                thread.join()
        inputs = self.inputs(self.folder / "drive")
        self.assertGreater(int(inputs[-1]["odometry.accepted"]), 20)
        self.assertGreater(int(inputs[-1]["odometry.refused"]), 0)
        self.assertGreater(int(inputs[-1]["event.accepted"]), 0)
        labels = {line["label"] for line in self.index(self.folder / "drive")}
        if "truth/steering" not in self.frame(self.folder / "live", 0)["stages"]:
            self.assertTrue({"forward", "left", "right"} <= labels, labels)
        self.replay(self.folder / "drive", self.folder / "again")
        self.assertEqual(self.assert_same_stages(self.folder / "live", self.folder / "again", 60), 60)

    def test_the_probe_records_a_running_daemon_and_from_there_on_a_replay_agrees_with_it(self):
        stop = threading.Event()
        daemon = Running("vdispd", "--sim", *sets("sim.rate=5", "sim.imu=yes"), "--dump", self.folder / "live", stdout=subprocess.DEVNULL)
        self.addCleanup(daemon.__exit__)
        self.assertTrue(wait_until(lambda: "ready" in daemon.text(), 20), daemon.text())
        threads = self.feed(stop)
        time.sleep(2)  # something to remember
        result = run("vdisp-probe", "record", self.folder / "drive", "--seconds", "8", "--json", timeout=60)
        stop.set()
        for thread in threads:
            thread.join()
        self.assertEqual(result.returncode, 0, result.stderr)
        told = json.loads(result.stdout)
        daemon.process.terminate()
        self.assertEqual(daemon.process.wait(20), 0, daemon.text())
        self.assertEqual((told["warning"], told["lost"]), ("", 0), told)
        self.assertGreater(int(self.inputs(self.folder / "drive")[0]["sequence"]), 5)
        self.replay(self.folder / "drive", self.folder / "again")
        self.assertGreater(self.assert_same_stages(self.folder / "live", self.folder / "again", 20), 20)
        # Planners hold on to these: in the live daemon they went on.
        frames = [json.loads((path / "frame.json").read_text()) for path in sorted((self.folder / "live").iterdir())]
        for numbers in ([frame[name]["generation"] for frame in frames if name in frame] for name in ("map_changes", "fused_changes")):
            self.assertGreater(len(numbers), 20)
            self.assertEqual(numbers, sorted(numbers))
        forgotten = [frame["memory"]["forgotten"] for frame in frames if "memory" in frame]
        self.assertEqual(forgotten, sorted(forgotten))

    def test_a_rate_takes_that_many_pairs_and_labels_come_from_the_orders(self):
        self.start("main.detectors=none")
        with subprocess.Popen([BIN / "vdisp-probe", "send", "drive", "--rate", "20"], stdin=subprocess.PIPE, text=True,
                              stdout=subprocess.DEVNULL) as sender:
            sender.stdin.write("0.3,0.0\n" * 30 + "0.0,0.5\n" * 30 + "0.0,-0.5\n" * 30)
            sender.stdin.close()
            result = run("vdisp-probe", "record", self.folder / "drive", "--rate", "5", "--seconds", "6", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        told = json.loads(result.stdout)
        self.assertTrue(27 <= told["pairs"] <= 33, told)
        pairs = self.index(self.folder / "drive")
        by_order = "truth/steering" not in run("vdisp-probe", "list").stdout
        for label in ("forward", "left", "right", "none") if by_order else ():  # none: an order that is not repeated is forgotten
            self.assertGreater(told["labels"][label], 2, told)
        apart = numpy.diff([int(pair["timestamp_ns"]) for pair in pairs]) * 1e-9
        self.assertLess(abs(numpy.median(apart) - 0.2), 0.04)


@unittest.skipUnless(shutil.which("Xvfb") and shutil.which("xdotool"), "needs Xvfb and xdotool")
class Hands(RecordingTest):
    """Keys and mouse in the window become orders, and nothing held becomes none."""

    def setUp(self):
        super().setUp()
        read, write = os.pipe()
        command = ["Xvfb", "-displayfd", str(write), "-screen", "0", "1100x760x24", "-nolisten", "tcp", "-noreset"]
        server = subprocess.Popen(command, pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        os.close(write)
        with os.fdopen(read) as number:
            self.display = {**os.environ, "DISPLAY": ":" + number.readline().strip()}
        daemon = Running("vdispd", "--sim", *sets("main.detectors=none"), stdout=subprocess.DEVNULL)
        self.addCleanup(daemon.__exit__)
        self.assertTrue(wait_until(lambda: "ready" in daemon.text(), 20), daemon.text())

    def do(self, *arguments):
        return subprocess.run(["xdotool", *map(str, arguments)], env=self.display, capture_output=True, text=True).stdout.strip()

    def window(self, *command):
        probe = Running("vdisp-probe", *command, env=self.display, cwd=self.folder, stdout=subprocess.PIPE, text=True)
        self.addCleanup(probe.process.stdout.close)
        self.addCleanup(probe.__exit__)
        self.assertTrue(wait_until(lambda: self.do("search", "--pid", probe.process.pid, "--name", "x")), probe.text())
        window = self.do("search", "--pid", probe.process.pid, "--name", "x").split()[0]
        self.do("windowfocus", "--sync", window)
        return probe, window

    def drive(self):
        self.number = getattr(self, "number", 0) + 1
        folder = self.folder / f"dump{self.number}"
        self.assertEqual(run("vdisp-probe", "dump", folder, "--once", "left", "in/drive").returncode, 0)
        return self.frame(folder, 0)

    def assert_order(self, speed, turn):
        def told():
            frame = self.drive()
            order = frame["drive"]
            return frame["stages"]["in/drive"]["valid"] and (order["speed"], order["turn_rate"]) == (speed, turn) and order["age_s"] < 0.15
        self.assertTrue(wait_until(told, 5), f"{speed}, {turn}: {self.drive()}")

    def assert_none(self):
        """The last order grows old: 300 ms and more."""
        self.assertTrue(wait_until(lambda: not self.drive()["stages"]["in/drive"]["valid"], 3), self.drive())

    def test_keys_held_are_orders_and_labels_and_let_go_they_end(self):
        drive = self.folder / "drive"
        probe, _ = self.window("record", drive, "--rate", 10, "--view", "--speed", "0.25", "--turn", "0.75", "--json")
        by_order = "truth/steering" not in run("vdisp-probe", "list").stdout
        def assert_label(label):
            """A key is held until a pair is taken with its label: ten a second are asked for, a loaded machine takes fewer."""
            if by_order:
                self.assertTrue(wait_until(lambda: any(row["label"] == label for row in self.index(drive)), 20), label)
        self.assertEqual(self.drive()["drive"]["accepted"], 0)
        self.do("keydown", "Up")
        self.assert_order(0.25, 0)
        assert_label("forward")
        self.do("keydown", "Left")
        self.assert_order(0.25, 0.75)
        self.do("keyup", "Up")
        self.assert_order(0, 0.75)
        assert_label("left")
        self.do("keyup", "Left")
        self.assert_none()
        self.do("keydown", "Right")
        self.assert_order(0, -0.75)
        assert_label("right")
        self.do("keyup", "Right")
        self.do("key", "q")
        self.assertEqual(probe.process.wait(10), 0, probe.text())
        told = json.loads(probe.process.stdout.read())
        for label in ("forward", "left", "right", "none") if by_order else ():
            self.assertGreater(told["labels"][label], 0, told)
        self.assertEqual(len(self.index(drive)), told["pairs"])

    def test_a_mouse_button_turns_and_none_goes_ahead_until_the_pointer_leaves(self):
        probe, window = self.window("view", "--drive")
        self.do("mousemove", "--window", window, 200, 300)
        self.assertEqual(self.drive()["drive"]["accepted"], 0)
        self.do("mousedown", 1)
        self.assert_order(0, 0.5)
        self.do("mouseup", 1)
        self.assert_order(0.3, 0)
        self.do("mousedown", 3)
        self.assert_order(0, -0.5)
        self.do("mouseup", 3)
        self.do("mousemove", 1090, 750)
        self.assert_none()
        self.do("mousemove", "--window", window, 200, 300)
        self.assert_none()

    def test_without_focus_and_without_the_probe_there_are_no_orders(self):
        probe, _ = self.window("view", "--drive")
        self.do("keydown", "Up")
        self.assert_order(0.3, 0)
        other, _ = self.window("view", "--stage", "left")
        self.assert_none()
        other.process.terminate()
        other.process.wait(10)
        self.do("keyup", "Up")
        probe.process.terminate()
        probe.process.wait(10)
        probe, _ = self.window("view", "--drive")
        self.do("keydown", "Up")
        self.assert_order(0.3, 0)
        probe.process.kill()
        self.assert_none()
        self.do("keyup", "Up")


class Cameras(RecordingTest):
    """Real cameras' packets: frames and odometry on one clock."""

    def daemon(self, *more, **values):
        named = {"image source.source": "aravis", "image source.width": 320, "image source.height": 240, "image source.rate": 10,
                 "image source.ndisp": 32, "camera.tolerance": 15, "image source.paramfile": self.folder / "calibration.yml", **values}
        return Running("vdispd", *[word for key, value in named.items() for word in ("--set", f"{key}={value}")], *more,
                       stdout=subprocess.DEVNULL)

    def cameras(self):
        """Two views of the simulator's ground."""
        made = run("vdispd", "--sim", *sets("sim.rate=0", "main.middleware=none"), "--frames", 1, "--record", self.folder / "made")
        self.assertEqual(made.returncode, 0, made.stderr)
        shutil.copy(self.folder / "made/calibration.yml", self.folder)
        views = [cv2.imread(str(next((self.folder / "made" / side).iterdir())), 0) for side in ("left", "right")]
        return [GigeCamera(self, address, serial, view) for address, serial, view in
                zip((gige.LEFT, gige.RIGHT), ("LEFT01", "RIGHT02"), views)]

    def test_a_live_run_with_a_lost_camera_is_replayed_to_the_same_stages_bit_by_bit(self):
        cameras = self.cameras()
        stop = threading.Event()
        with self.daemon("--frames", 60, "--dump", self.folder / "live", "--record", self.folder / "drive") as daemon:
            threads = self.feed(stop)
            self.assertTrue(wait_until(lambda: len(list((self.folder / "live").glob("*/frame.json"))) > 25 if (self.folder / "live").exists() else False, 60), daemon.text())
            cameras[1].kill()
            self.assertEqual(daemon.process.wait(180), 0, daemon.text())
            stop.set()
            for thread in threads:
                thread.join()
        steps = self.inputs(self.folder / "drive")
        self.assertEqual(len(steps), 60)
        self.assertGreater(sum(step["reason"] == "none" for step in steps), 20)
        self.assertGreater(sum(step["reason"] != "none" for step in steps), 2)
        self.assertEqual({step["flags"] for step in steps}, {"0"}, "not synthetic")
        fused = [json.loads(path.read_text())["memory"]["state"] for path in (self.folder / "live").glob("*/frame.json")
                 if "memory" in json.loads(path.read_text())]
        self.assertIn("fused", fused, "odometry was used: times are of one clock")
        self.replay(self.folder / "drive", self.folder / "again")
        self.assertEqual(self.assert_same_stages(self.folder / "live", self.folder / "again", 60), 60)
        self.assertTrue(json.loads((self.folder / "again/000000/frame.json").read_text())["synthetic"])

    def test_a_lost_camera_makes_the_flight_recorder_write(self):
        cameras = self.cameras()
        values = {"recorder.folder": self.folder / "flight", "recorder.seconds": 2, "recorder.free": 0, "main.detectors": "none"}
        with self.daemon(**values) as daemon:
            self.assertTrue(wait_until(lambda: "ready" in daemon.text(), 20), daemon.text())
            time.sleep(2)
            cameras[0].kill()
            self.assertTrue(wait_until(lambda: any("camera_lost" in name for name in self.flights()), 20), daemon.text())


isolated_main(network=True)
