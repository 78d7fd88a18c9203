#!/usr/bin/python3
"""150: recordings of the real programs: labelled, whole whatever happens, and replayed to the same stages bit by bit.

SPDX-License-Identifier: Apache-2.0
"""
import json
import os
import re
import shutil
import subprocess
import time

import cv2
import numpy

from programs import BIN, Running, isolated_main, run, wait_until
from recordings import RecordingTest, hashed, sets


class Recording(RecordingTest):
    def test_the_simulators_own_odometry_and_imu_are_replayed_too_and_the_line_floor_as_well(self):
        for number, floor in enumerate(("profile", "line")):
            live, drive, again = (self.folder / f"{name}{number}" for name in ("live", "drive", "again"))
            result = run("vdispd", "--sim", *sets("sim.rate=0", "sim.odometry=yes", "sim.imu=yes", "main.middleware=none", f"Floor.model={floor}"),
                         "--frames", 20, "--dump", live, "--record", drive, timeout=120)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.replay(drive, again)
            self.assert_same_stages(live, again, 20)

    def test_a_replay_takes_nothing_from_the_recorded_machine(self):
        drive = self.small_recording()
        config = drive / "vdisp.cfg"
        text = config.read_text()
        metrics = self.folder / "served.prom"
        metrics.write_text("of the daemon that serves\n")
        for key, value in (("scheduling", "fifo"), ("cpus", "1000"), ("lockMemory", "yes"), ("period", "30000"), ("metrics", metrics)):
            text, count = re.subn(rf"(?m)^{key} = .*$", f"{key} = {value}", text, count=1)
            self.assertEqual(count, 1, key)
        config.write_text(text)
        # A user without rights of its own: neither real time nor locked memory is permitted.
        words = ["setpriv", "--bounding-set=-all", "--inh-caps=-all", "prlimit", "--rtprio=0", "--memlock=65536", BIN / "vdisp-probe", "replay", drive, "--",
                 "--dump", self.folder / "again", "--set", "main.middleware=none"]
        result = subprocess.run(list(map(str, words)), capture_output=True, text=True, timeout=25)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(len(list((self.folder / "again").iterdir())), 3)
        self.assertEqual(metrics.read_text(), "of the daemon that serves\n")
        self.assert_refused(run("vdisp-probe", "replay", drive, "--", "--set", "main.cpus=1000", "--set", "main.middleware=none"), 78, "cpus")

    def test_a_replay_attaches_to_nobody_and_so_waits_for_nobody(self):
        self.assert_refused(run("vdisp-probe", "replay", self.small_recording(), "--wait", "1"), 64, "--wait")

    def test_a_folder_called_as_the_daemon_beside_the_probe_is_not_taken_for_it(self):
        place = self.folder / "tree"
        (place / "vdispd").mkdir(parents=True)
        shutil.copy(BIN / "vdisp-probe", place)
        words = [place / "vdisp-probe", "replay", self.small_recording(), "--", "--set", "main.middleware=none"]
        found = subprocess.run(list(map(str, words)), capture_output=True, text=True, timeout=60, env={**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}"})
        self.assertEqual(found.returncode, 0, found.stderr)

    def test_names_and_index_are_as_documented_and_calibration_and_configuration_lie_beside(self):
        result = run("vdispd", "--sim", *sets("sim.rate=0", "main.middleware=none", "sim.seed=7"), "--frames", 3, "--record", self.folder / "drive")
        self.assertEqual(result.returncode, 0, result.stderr)
        lines = (self.folder / "drive/index.csv").read_text().splitlines()
        self.assertEqual(lines[0], "timestamp_ns,label,left,right,speed,turn_rate")
        for line in self.index(self.folder / "drive"):
            self.assertEqual(line["left"], f"left/{line['timestamp_ns']}_{line['label']}.png")
            for side in ("left", "right"):
                picture = cv2.imread(str(self.folder / "drive" / line[side]), cv2.IMREAD_UNCHANGED)
                self.assertEqual((picture.shape, picture.dtype), ((240, 320), numpy.uint8))
        told = json.loads((self.folder / "drive/recording.json").read_text())
        self.assertEqual((told["source"], told["seed"], told["width"], told["synthetic"]), ("sim", 7, 320, True))
        self.assertEqual(run("vdisp-calibrate", "show", self.folder / "drive/calibration.yml").returncode, 0)
        self.assertEqual(run("vdispd", "-c", self.folder / "drive/vdisp.cfg", "--check-config").returncode, 0)

    def test_a_folder_that_holds_a_recording_is_refused_with_73(self):
        command = ("vdispd", "--sim", *sets("sim.rate=0", "main.middleware=none"), "--frames", 2, "--record", self.folder / "drive")
        self.assertEqual(run(*command).returncode, 0)
        before = hashed(self.folder / "drive", {})
        self.assert_refused(run(*command), 73, "holds a recording already")
        self.assertEqual(hashed(self.folder / "drive", {}), before)
        self.assert_refused(run("vdispd", "--sim", "--record", ""), 64, "--record", "empty")

    def test_a_full_disk_ends_it_with_74_and_what_was_whole_is_kept(self):
        place = self.folder / "small"
        place.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=3m", "none", place], check=True)
        self.addCleanup(subprocess.run, ["umount", "-l", place])
        result = run("vdispd", "--sim", *sets("sim.rate=0", "main.middleware=none", "main.debug=0"), "--frames", 500, "--record", place / "drive",
                     timeout=120)
        self.assertEqual(result.returncode, 74, result.stderr)
        lines = [line for line in result.stderr.splitlines() if "No space left" in line]
        self.assertEqual(len(lines), 1, result.stderr)
        self.assertIn("free some space", lines[0])
        pairs = self.index(place / "drive")
        self.assertGreater(len(pairs), 5)
        self.assertEqual([p.name for p in (place / "drive").rglob(".*")], [])
        self.assertEqual(len(list((place / "drive/left").iterdir())), len(pairs))
        self.assertEqual(len(list((place / "drive/right").iterdir())), len(pairs))
        self.replay(place / "drive", self.folder / "again")
        self.assertEqual(len(list((self.folder / "again").iterdir())), len(pairs))

    def test_killed_at_any_moment_the_whole_pairs_are_kept_and_replayed(self):
        for number, after in enumerate((0.0, 0.11, 0.23, 0.37, 0.52)):
            drive = self.folder / f"drive{number}"
            with Running("vdispd", "--sim", *sets("sim.rate=0", "main.middleware=none", "main.detectors=none"), "--record", drive) as daemon:
                self.assertTrue(wait_until(lambda: (drive / "index.csv").exists() and len(self.index(drive)) > 3, 30), daemon.text())
                time.sleep(after)
                daemon.process.kill()
                daemon.process.wait()
            whole = len(self.index(drive))
            self.replay(drive, self.folder / f"again{number}")
            self.assertGreaterEqual(len(list((self.folder / f"again{number}").iterdir())), whole - 1)

    def test_a_broken_recording_is_refused_with_66_and_one_line(self):
        drive = self.folder / "drive"
        def fresh():
            shutil.rmtree(drive, ignore_errors=True)
            self.assertEqual(run("vdispd", "--sim", *sets("sim.rate=0", "main.middleware=none"), "--frames", 3, "--record", drive).returncode, 0)
            return self.index(drive)
        def refused(*words):
            for command in (("vdispd", "--set", "image source.source=files", "--set", f"image source.recording={drive}"),
                            ("vdisp-probe", "replay", drive)):
                self.assert_refused(run(*command), 66, *words)
        refused("no such folder")
        (drive / fresh()[1]["right"]).unlink()
        refused("is missing", "both pictures")
        line = fresh()[1]
        os.rename(drive / line["left"], drive / "left/up.png")
        refused("is missing")
        index = drive / "index.csv"
        fresh()
        index.write_text(re.sub(r"_(\w+)\.png,right", r"_backward.png,right", index.read_text(), count=1))
        refused("line 2", "must be left/")
        fresh()
        index.write_text(index.read_text().replace(f",{line['label']},", ",backward,", 1))
        refused("label 'backward' is unknown", "forward, left, right")
        picture = drive / fresh()[0]["left"]
        cv2.imwrite(str(picture), numpy.zeros((100, 100), numpy.uint8))
        refused("is 100x100", "320x240")

    def test_a_last_line_that_was_cut_off_is_left_out(self):
        drive = self.folder / "drive"
        self.assertEqual(run("vdispd", "--sim", *sets("sim.rate=0", "main.middleware=none"), "--frames", 5, "--record", drive).returncode, 0)
        text = (drive / "index.csv").read_bytes()
        (drive / "index.csv").write_bytes(text[:-20])
        result = self.replay(drive, self.folder / "again")
        self.assertEqual(len(list((self.folder / "again").iterdir())), 4)
        self.assertIn("was cut off", result.stderr)

    def test_recording_and_left_are_not_both(self):
        self.assert_refused(run("vdispd", "--set", "image source.source=files", "--set", "image source.recording=x", "--set",
                                "image source.left=y"), 78, "must be one of them")

    def test_what_comes_in_during_a_replay_changes_nothing_of_it(self):
        drive = self.folder / "drive"
        self.assertEqual(run("vdispd", "--sim", *sets("sim.rate=0", "main.middleware=none"), "--frames", 20, "--record", drive).returncode, 0)
        with Running("vdispd", "--set", "image source.source=files", "--set", f"image source.recording={drive}", "--set",
                     "image source.loop=yes", "--set", "image source.rate=30", "--set", "image source.ndisp=32", stdout=subprocess.DEVNULL) as daemon:
            self.assertTrue(wait_until(lambda: "ready" in daemon.text()), daemon.text())
            for kind, line in (("odometry", "1,2,3"), ("imu", "0,0,9.8"), ("drive", "1,0")):
                run("vdisp-probe", "send", kind, input=line + "\n")
            run("vdisp-probe", "send", "event", "hello")
            time.sleep(0.3)
            self.assertEqual(run("vdisp-probe", "dump", self.folder / "dump", "--once", "left", "in/odometry", "in/imu", "in/drive", "in/event").returncode, 0)
            stages = self.frame(self.folder / "dump", 0)["stages"]
            self.assertEqual([stages[f"in/{kind}"]["reason"] for kind in ("odometry", "imu", "drive", "event")],
                             ["no_odometry", "no_imu", "no_drive", "no_event"])

    def test_texts_and_paths_of_the_configuration_are_what_they_were_whatever_they_hold(self):
        place = self.folder / "run #3 $lab; \"x\""
        place.mkdir()
        calibration = place / "rover.yml"
        shutil.copy(self.small_recording() / "calibration.yml", calibration)

        def paramfile(config):
            printed = run("vdispd", "-c", config, "--print-config")
            self.assertEqual(printed.returncode, 0, printed.stderr)
            return re.search(r"(?m)^paramfile = .*$", printed.stdout)[0]
        own = self.folder / "own.cfg"
        text = str(calibration)
        for letter in '\\"$':
            text = text.replace(letter, "\\" + letter)
        own.write_text(f"[image source]\nparamfile = \"{text}\"\n")
        self.start("main.detectors=none", first=("-c", own))
        recorded = run("vdisp-probe", "record", self.folder / "paths", "--rate", "5", "--seconds", "1", "--json")
        self.assertEqual(recorded.returncode, 0, recorded.stderr)
        self.assertEqual(paramfile(self.folder / "paths/vdisp.cfg"), paramfile(own))
        (self.folder / "paths").rename(place / "drive")
        self.replay(place / "drive", self.folder / "again")

    def test_a_recording_without_a_configuration_says_so(self):
        self.start("main.detectors=none")
        for options in (("--rate", "5"), ("--running",), ()):
            drive = self.folder / f"drive{len(options)}"
            told = json.loads(run("vdisp-probe", "record", drive, *options, "--seconds", "1", "--control", "/nowhere/control", "--json").stdout)
            self.assertFalse((drive / "vdisp.cfg").exists())
            self.assertIn("has no vdisp.cfg", told["warning"])
            self.assertIn("/nowhere/control", told["warning"])
            self.assertEqual("remember what came before" in told["warning"], not options)

    def test_the_probe_keeps_what_was_whole_when_its_disk_is_full_or_the_daemon_ends(self):
        place = self.folder / "small"
        place.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=2m", "none", place], check=True)
        self.addCleanup(subprocess.run, ["umount", "-l", place])
        daemon = self.start("main.detectors=none")
        self.assert_refused(run("vdisp-probe", "record", place / "drive"), 74, "No space left")
        pairs = self.index(place / "drive")
        self.assertGreater(len(pairs), 3)
        self.assertEqual(len(list((place / "drive/left").iterdir())), len(pairs))
        with Running("vdisp-probe", "record", self.folder / "drive", stdout=subprocess.DEVNULL) as probe:
            self.assertTrue(wait_until(lambda: (self.folder / "drive/index.csv").exists() and len(self.index(self.folder / "drive")) > 5))
            daemon.process.kill()
            self.assertEqual(probe.process.wait(20), 69, probe.text())
        self.assertEqual(len(probe.text().splitlines()), 1, probe.text())
        self.assertGreater(len(self.index(self.folder / "drive")), 5)


isolated_main()
