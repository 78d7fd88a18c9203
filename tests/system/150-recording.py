#!/usr/bin/python3
"""150: recordings of the real programs: labelled, whole whatever happens, and replayed to the same stages bit by bit.

SPDX-License-Identifier: Apache-2.0
"""
import csv
import hashlib
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import threading
import time
import unittest

import cv2
import numpy

import gige
from gige import GigeCamera
from programs import BIN, ProgramTest, Running, isolated_main, run, wait_until

SMALL = {"sim.width": 320, "sim.height": 240, "image source.ndisp": 32, "sim.rate": 30}
NOT_OF_THE_FRAME = ("truth/", "camera/status")  # a replay has no truth and no cameras


def sets(*more, **named):
    values = {**SMALL, **dict(item.split("=", 1) for item in more)}
    return [word for key, value in values.items() for word in ("--set", f"{key}={value}")]


def counted_from_the_first(told, first):
    """What never goes back in a daemon's life counts on where a recording begins, and from the start in a replay: told from the first frame on.
    `first` belongs to one dump."""
    for name in ("map_changes", "fused_changes"):
        if name in told:
            told[name]["generation"] -= first.setdefault(name, told[name]["generation"])
    if "memory" in told:
        told["memory"]["forgotten"] -= first.setdefault("memory", told["memory"]["forgotten"])
    for track in told.get("tracks", {}).get("tracks", []):
        track["id"] -= first.setdefault("tracks", track["id"])


def hashed(frame, first):
    """A hash for each stage of a dumped frame, and the members of frame.json that tell of it."""
    found = {}
    for path in sorted(frame.rglob("*")):
        name = str(path.relative_to(frame))
        if path.is_dir() or name == "timing.json" or name.startswith(NOT_OF_THE_FRAME):
            continue
        if name != "frame.json":
            found[name] = hashlib.sha256(path.read_bytes()).hexdigest()
            continue
        told = json.loads(path.read_text())
        told["files"] = told["truth_scene"] = told["camera_status"] = told["synthetic"] = None
        for part in ("stages", "rejected"):
            told[part] = {key: value for key, value in told[part].items() if not key.startswith(NOT_OF_THE_FRAME)}
        counted_from_the_first(told, first)
        found["frame.json"] = json.dumps(told, sort_keys=True)
    return found


class Recording(ProgramTest):
    def index(self, folder):
        with open(folder / "index.csv") as file:
            return list(csv.DictReader(file))

    def inputs(self, folder):
        with open(folder / "inputs.csv") as file:
            return list(csv.DictReader(file))

    def replay(self, recording, dump, *options):
        result = run("vdisp-probe", "replay", recording, "--", "--dump", dump, "--set", "main.middleware=none", *options, timeout=200)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def assert_same_stages(self, live, again, least, first=0):
        """Every frame of the dump `again` equals that of `live` with the same sequence."""
        frames = {json.loads((path / "frame.json").read_text())["sequence"]: path for path in live.iterdir()}
        seen, of_live, of_again = 0, {}, {}
        for path in sorted(again.iterdir()):
            sequence = json.loads((path / "frame.json").read_text())["sequence"]
            a, b = hashed(frames[sequence], of_live), hashed(path, of_again)
            self.assertEqual(sorted(a), sorted(b), sequence)
            for name in a:
                self.assertEqual(a[name], b[name], f"frame {sequence}: {name}")
            seen += 1
        self.assertGreaterEqual(seen, least)
        return seen

    def end(self, sender):
        try:
            sender.stdin.close()
        except OSError:  # the daemon was gone before
            pass

    def feed(self, stop):
        """Odometry, IMU, orders and events at rates of their own, some of them refused."""
        def odometry():
            lines, begin = "x,y,yaw\n", time.monotonic()
            with subprocess.Popen([BIN / "vdisp-probe", "send", "odometry", "--wait", "30"], stdin=subprocess.PIPE, text=True,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as sender:
                try:
                    sender.stdin.write(lines)
                    while not stop.is_set():
                        passed = time.monotonic() - begin
                        jump = 50 if int(passed * 50) % 40 == 39 else 0
                        sender.stdin.write(f"{0.4 * passed + jump},{0.02 * passed},{0.05 * passed}\n")
                        sender.stdin.flush()
                        time.sleep(0.02)
                except OSError:
                    pass
                self.end(sender)
        def others():
            count = 0
            with subprocess.Popen([BIN / "vdisp-probe", "send", "imu", "--wait", "30"], stdin=subprocess.PIPE, text=True,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as imu, \
                 subprocess.Popen([BIN / "vdisp-probe", "send", "drive", "--wait", "30"], stdin=subprocess.PIPE, text=True,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as drive:
                try:
                    while not stop.is_set():
                        imu.stdin.write(f"0.1,{0.01 * (count % 7)},9.8,0.01,0.02,{0.001 * count}\n")
                        drive.stdin.write(f"0.3,{(0, 0.5, -0.5)[count // 20 % 3]}\n")
                        imu.stdin.flush(), drive.stdin.flush()
                        if count % 25 == 10:
                            run("vdisp-probe", "send", "event", f'door "{count}", left')
                        count += 1
                        time.sleep(0.03)
                except OSError:
                    pass
                self.end(imu)
                self.end(drive)
        threads = [threading.Thread(target=work) for work in (odometry, others)]
        for thread in threads:
            thread.start()
        return threads

    # --record
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

    def test_the_simulators_own_odometry_and_imu_are_replayed_too_and_the_line_floor_as_well(self):
        for number, floor in enumerate(("profile", "line")):
            live, drive, again = (self.folder / f"{name}{number}" for name in ("live", "drive", "again"))
            result = run("vdispd", "--sim", *sets("sim.rate=0", "sim.odometry=yes", "sim.imu=yes", "main.middleware=none", f"Floor.model={floor}"),
                         "--frames", 20, "--dump", live, "--record", drive, timeout=120)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.replay(drive, again)
            self.assert_same_stages(live, again, 20)

    def small_recording(self, *more):
        drive = self.folder / "drive"
        made = run("vdispd", "--sim", *sets("sim.rate=0", "main.middleware=none", *more), "--frames", 3, "--record", drive)
        self.assertEqual(made.returncode, 0, made.stderr)
        return drive

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

    # vdisp-probe record
    def start(self, *options, first=(), **named):
        daemon = Running("vdispd", *first, "--sim", *sets(*options), stdout=subprocess.DEVNULL, **named)
        self.addCleanup(daemon.__exit__)
        self.assertTrue(wait_until(lambda: "ready" in daemon.text() or daemon.process.poll() is not None, 60), daemon.text())
        return daemon

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

    # the flight recorder
    def flights(self):
        place = self.folder / "flight"
        return sorted(path.name for path in place.iterdir()) if place.exists() else []

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
        for seed, drive in zip((2, 4), drives):
            sets = [word for item in (*size, f"sim.seed={seed}", "sim.drive=expert", "sim.exploration=0.5", "main.detectors=none", "main.middleware=none")
                    for word in ("--set", item)]
            self.assertEqual(run("vdispd", "--sim", *sets, "--frames", 200, "--record", drive, timeout=120).returncode, 0)
        model = self.folder / "first.model"
        trained = run("vdisp-train", "train", *drives, "--hold-out", 0, "--size", "160x120", "--width", 32, "-o", model)
        self.assertEqual(trained.returncode, 0, trained.stderr)
        # Ahead, whatever is there.
        daemon = self.start(*size, "sim.seed=6", "sim.drive=command", f"recorder.folder={self.folder}/flight", "recorder.seconds=4", "recorder.free=0")
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


@unittest.skipUnless(shutil.which("Xvfb") and shutil.which("xdotool"), "needs Xvfb and xdotool")
class Hands(ProgramTest):
    """Keys and mouse in the window become orders, and nothing held becomes none."""
    index = Recording.index

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


class Cameras(ProgramTest):
    """Real cameras' packets: frames and odometry on one clock."""
    replay, assert_same_stages, feed, end = Recording.replay, Recording.assert_same_stages, Recording.feed, Recording.end
    inputs, flights = Recording.inputs, Recording.flights

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


if __name__ == "__main__":
    isolated_main(network=True)
