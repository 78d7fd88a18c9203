#!/usr/bin/python3
"""152: the flight recorder: the last seconds are written when something happens or is asked, and only then.

SPDX-License-Identifier: Apache-2.0
"""
import json
import pathlib
import signal
import subprocess
import time

from programs import BIN, Running, isolated_main, run, wait_until
from recordings import RecordingTest


class FlightRecorder(RecordingTest):
    def flight(self, *options):
        return self.start(f"recorder.folder={self.folder}/flight", "recorder.seconds=1.5", "recorder.free=0", "main.detectors=none", *options)

    def test_dump_flight_writes_the_last_seconds_and_tells_where(self):
        self.flight()
        time.sleep(2)
        told = json.loads(run("vdisp-probe", "dump-flight", "--json").stdout)
        self.assertIn("asked", told["folder"])
        steps = self.inputs(pathlib.Path(told["folder"]))
        self.assertTrue(15 <= len(steps) <= 50, len(steps))  # 1.5 s at 30 Hz, of a busy machine fewer
        sequences = [int(step["sequence"]) for step in steps]
        self.assertEqual(sequences, list(range(sequences[0], sequences[0] + len(sequences))))
        self.replay(pathlib.Path(told["folder"]), self.folder / "again")

    def test_a_signal_and_a_bump_write_it_and_it_goes_on(self):
        daemon = self.flight()
        time.sleep(1)
        daemon.process.send_signal(signal.SIGUSR1)
        self.assertTrue(wait_until(lambda: any("signal" in name for name in self.flights())), daemon.text())
        time.sleep(2)
        run("vdisp-probe", "send", "event", "bump front")
        self.assertTrue(wait_until(lambda: any("bump" in name for name in self.flights())), daemon.text())
        self.assertTrue(wait_until(lambda: daemon.text().count("flight recorder:") == 2), daemon.text())
        bump = next(self.folder / "flight" / name for name in self.flights() if "bump" in name)
        self.assertIn("bump front", (bump / "inputs.csv").read_text().splitlines()[-1])

    def test_a_simulated_robots_collision_is_written_with_the_experts_labels_and_joins_the_training(self):
        size = ("sim.width=160", "sim.height=120", "image source.ndisp=32", "sim.rate=10", "sim.scene=office")
        drives = [self.folder / f"drive{seed}" for seed in (2, 4)]
        driven = []  # both at once: they keep the simulator's time, and have nothing to do for most of it
        for seed, drive in zip((2, 4), drives):
            sets = [word for item in (*size, f"sim.seed={seed}", "sim.drive=expert", "sim.exploration=0.5", "main.detectors=none", "main.middleware=none")
                    for word in ("--set", item)]
            driven.append(Running("vdispd", "--sim", *sets, "--frames", 200, "--record", drive))
            self.addCleanup(driven[-1].__exit__)
        for daemon in driven:
            self.assertEqual(daemon.process.wait(120), 0, daemon.text())
        model = self.folder / "first.model"
        trained = run("vdisp-train", "train", *drives, "--hold-out", 0, "--size", "160x120", "--width", 32, "-o", model)
        self.assertEqual(trained.returncode, 0, trained.stderr)
        # Ahead, whatever is there.
        daemon = self.start(*size, "sim.seed=3", "sim.drive=command", f"recorder.folder={self.folder}/flight", "recorder.seconds=4", "recorder.free=0")
        with subprocess.Popen([BIN / "vdisp-probe", "send", "drive", "--wait", "5"], stdin=subprocess.PIPE, text=True, stdout=subprocess.DEVNULL) as sender:
            def driven():
                sender.stdin.write("0.5,0\n")
                sender.stdin.flush()
                return self.flights()
            self.assertTrue(wait_until(driven, 60), daemon.text())
            self.end(sender)
        self.assertTrue(wait_until(lambda: "flight recorder:" in daemon.text()), daemon.text())
        self.assertIn("sim: collision 1", daemon.text())
        flight = self.folder / "flight" / self.flights()[0]
        self.assertIn("bump", flight.name)
        labels = [pair["label"] for pair in self.index(flight)]
        self.assertGreater(len(labels), 20)
        self.assertNotIn("none", labels)
        self.assertTrue({"left", "right"} & set(labels[-8:]), labels)  # what it ran into was in the expert's way
        added = run("vdisp-train", "train", "--add", flight, "-o", model, "--json")
        self.assertEqual(added.returncode, 0, added.stderr)
        self.assertEqual(json.loads(added.stdout)["trained_with"]["drives"], 3)

    def test_a_lost_floor_writes_it_once(self):
        daemon = self.start(f"recorder.folder={self.folder}/flight", "recorder.seconds=1.5", "recorder.free=0", "sim.event=cap", "sim.eventFrame=40")
        self.assertTrue(wait_until(lambda: any("floor_lost" in name for name in self.flights()), 30), daemon.text())
        time.sleep(3)
        self.assertEqual(len(self.flights()), 1)

    def test_only_so_many_folders_are_kept_and_a_stranger_is_left_alone(self):
        (self.folder / "flight/flight-plan").mkdir(parents=True)
        self.flight("recorder.keep=2")
        names = [pathlib.Path(json.loads(run("vdisp-probe", "dump-flight", "--json").stdout)["folder"]).name for _ in range(4)]
        self.assertEqual(self.flights(), sorted([*names[-2:], "flight-plan"]))

    def test_without_room_on_the_disk_nothing_is_written_and_the_probe_says_why(self):
        self.start(f"recorder.folder={self.folder}/flight", "recorder.seconds=1", "recorder.free=1048576")
        self.assert_refused(run("vdisp-probe", "dump-flight"), 74, "MiB are free", "[recorder] free")
        self.assertEqual(self.flights(), [])

    def test_a_folder_that_cannot_be_written_is_said_at_the_start(self):
        (self.folder / "file").touch()
        daemon = self.start(f"recorder.folder={self.folder}/file/flight", "recorder.seconds=1", "main.detectors=none")
        self.assertRegex(daemon.text(), r"flight recorder: .*/file/flight: cannot be written \(Not a directory\).*ReadWritePaths")
        self.assertIsNone(daemon.process.poll(), "the rover is not blind for it")
        good = self.folder / "good"
        daemon.process.terminate()
        daemon.process.wait(20)
        time.sleep(0.1)  # iceoryx refuses a successor within milliseconds
        daemon = self.start(f"recorder.folder={good}/flight", "recorder.seconds=1", "main.detectors=none")
        self.assertNotIn("flight recorder:", daemon.text())
        self.assertTrue((good / "flight").is_dir())

    def test_a_disk_that_is_full_before_the_end_keeps_the_whole_pairs_and_the_daemon_goes_on(self):
        place = self.folder / "flight"
        place.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=50m,nr_inodes=30", "none", place], check=True)  # names run out before bytes do
        self.addCleanup(subprocess.run, ["umount", "-l", place])
        daemon = self.start(f"recorder.folder={place}", "recorder.seconds=1", "recorder.free=0", "main.detectors=none")
        time.sleep(2)
        self.assert_refused(run("vdisp-probe", "dump-flight"), 74, "No space left")
        self.assertIn("flight recorder:", daemon.text())
        pairs = self.index(place / self.flights()[0])
        self.assertTrue(5 <= len(pairs) <= 15, len(pairs))
        self.replay(place / self.flights()[0], self.folder / "again")
        self.assertIsNone(daemon.process.poll())

    def test_memory_bounds_the_ring_and_without_a_recorder_it_is_said(self):
        self.flight("recorder.memory=1", "recorder.seconds=600")
        time.sleep(1.5)
        told = json.loads(run("vdisp-probe", "dump-flight", "--json").stdout)
        self.assertLessEqual(len(self.index(pathlib.Path(told["folder"]))), 7)  # 1 MiB holds six pairs of 320x240
        recorder = json.loads(run("vdisp-probe", "stats", "--once", "--json").stdout)["recorder"]
        self.assertEqual((recorder["flight"]["written"], recorder["flight"]["failed"], recorder["flight"]["writing"]), (1, 0, False), recorder)
        self.assertLessEqual(recorder["flight"]["held"], 6)

    def test_without_a_flight_recorder_the_probe_and_the_signal_say_so(self):
        daemon = self.start("main.detectors=none")
        self.assert_refused(run("vdisp-probe", "dump-flight"), 78, "[recorder] seconds")
        told = json.loads(run("vdisp-probe", "stats", "--once", "--json").stdout)["recorder"]
        self.assertEqual((told["recording"], told["flight"]), (False, None))
        daemon.process.send_signal(signal.SIGUSR1)
        self.assertTrue(wait_until(lambda: "no flight recorder" in daemon.text()), daemon.text())
        self.assertIsNone(daemon.process.poll())


isolated_main()
