#!/usr/bin/python3
"""200: vdisp-probe on the real shared memory: what it prints, writes and shows, and what it says when it cannot.

SPDX-License-Identifier: Apache-2.0
"""
import json
import os
import pathlib
import pty
import re
import shutil
import signal
import subprocess
import sys
import termios
import time
import unittest

import cv2

from programs import BIN, ProgramTest, Running, isolated_main, run, wait_until

WORDS = (["list"], ["map", "--once"], ["stats", "--once"], ["sheet", "x.png"], ["dump", "x"], ["why", "1", "1"])


class Probe(ProgramTest):
    def publisher(self, *options):
        running = Running("vdisp-publish", *options, stdout=subprocess.DEVNULL)
        self.addCleanup(running.__exit__)
        self.assertTrue(wait_until(lambda: run("vdisp-probe", "list").returncode == 0), running.text())
        return running

    def test_wrong_usage_is_64(self):
        self.assert_refused(run("vdisp-probe"), 64, "--help")
        self.assert_refused(run("vdisp-probe", "lst"), 64, "lst")
        self.assert_refused(run("vdisp-probe", "dump"), 64, "DIR")
        self.assert_refused(run("vdisp-probe", "dump", "x", "--frames", "0"), 64, "--frames")

    def test_a_name_that_no_daemon_can_have_is_64(self):
        self.assert_refused(run("vdisp-probe", "list", "--name", "a,b"), 64, "'a,b'", "no comma")

    def test_without_a_daemon_every_word_is_69_and_writes_nothing(self):
        for word in WORDS:
            with self.subTest(word=word[0]):
                self.assert_refused(run("vdisp-probe", *word, cwd=self.folder), 69, "vdispd")
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_wait_waits_for_the_daemon(self):
        with Running("vdisp-probe", "list", "--wait", "20", stdout=subprocess.DEVNULL) as probe:
            time.sleep(0.5)
            self.assertIsNone(probe.process.poll())
            self.publisher()
            self.assertEqual(probe.process.wait(10), 0, probe.text())

    def test_every_word_that_is_stopped_while_it_waits_for_a_daemon_ends_with_0_and_no_word(self):
        for word in WORDS:
            with self.subTest(word=word[0]), Running("vdisp-probe", *word, "--wait", "20", cwd=self.folder, stdout=subprocess.DEVNULL) as probe:
                handles = lambda: int(re.search(r"SigCgt:\s*(\w+)", pathlib.Path(f"/proc/{probe.process.pid}/status").read_text())[1], 16) >> 14 & 1
                self.assertTrue(wait_until(handles, 5), "SIGTERM is handled")
                time.sleep(0.1)
                probe.process.terminate()
                self.assertEqual((probe.process.wait(10), probe.text()), (0, ""))

    def test_a_probe_that_is_stopped_while_it_attaches_attaches_when_it_goes_on(self):
        self.publisher()
        probes = []
        for i in range(30):
            probes.append(Running("vdisp-probe", "list", stdout=subprocess.DEVNULL))
            self.addCleanup(probes[-1].__exit__)
            time.sleep(0.004 * (i + 1))
            probes[-1].process.send_signal(signal.SIGSTOP)
        time.sleep(3)
        for i, probe in enumerate(probes):
            probe.process.send_signal(signal.SIGCONT)
            self.assertEqual(probe.process.wait(20), 0, f"stopped after {4 * (i + 1)} ms: {probe.text()}")

    def test_a_healthy_daemon_answers_every_call_also_on_a_busy_machine(self):
        self.publisher()
        busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(2 * os.cpu_count())]
        try:
            for i in range(30):
                result = run("vdisp-probe", "list")
                self.assertEqual(result.returncode, 0, f"call {i}: {result.stderr}")
        finally:
            for process in busy:
                process.kill()
                process.wait()

    def test_a_stopped_daemon_and_one_of_another_name_are_told_apart(self):
        daemon = self.publisher()
        self.assert_refused(run("vdisp-probe", "list", "-n", "other"), 69, "'other'", "[main] name of vdispd another")
        daemon.process.send_signal(signal.SIGSTOP)
        try:
            for word in WORDS:
                with self.subTest(word=word[0]):
                    start = time.monotonic()
                    self.assert_refused(run("vdisp-probe", *word, cwd=self.folder), 69, "hangs or is stopped")
                    self.assertLess(time.monotonic() - start, 5)
        finally:
            daemon.process.send_signal(signal.SIGCONT)
        self.assertEqual(run("vdisp-probe", "list").returncode, 0)

    def test_output_that_cannot_be_written_is_74(self):
        self.publisher()
        for word in (["list"], ["list", "--json"], ["stats", "--once"], ["map", "--once"], ["dump", "x"], ["sheet", "x.png"],
                     ["stats"], ["stats", "--json"], ["map"], ["map", "--json"]):
            with self.subTest(word=word), open("/dev/full", "w") as full:
                command = [BIN / "vdisp-probe", *word]
                result = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, timeout=20, cwd=self.folder)
                self.assert_refused(result, 74, "output", "No space left")

    def test_list_tells_the_tree_also_as_json(self):
        self.publisher()
        topics = {t["topic"]: t for t in json.loads(run("vdisp-probe", "list", "--json").stdout)}
        self.assertEqual(list(topics), ["left", "copy", "floor_model", "map"])
        self.assertEqual((topics["map"]["pixel"], topics["map"]["width"], topics["map"]["height"]), ("count16", 51, 50))
        self.assertEqual((topics["copy"]["parents"], topics["copy"]["delayed_parents"]), (["left"], []))
        self.assertEqual((topics["floor_model"]["parents"], topics["floor_model"]["delayed_parents"]), (["left"], ["floor_model"]))
        lines = run("vdisp-probe", "list", env={**os.environ, "LC_ALL": "C"}).stdout.splitlines()
        self.assertRegex(lines[2], r"^\|-copy +gray8 640x480 ")
        self.assertRegex(lines[3], r"^\|-floor_model .* \+ last floor_model$")

    def test_stats_counts_and_its_json_is_one_line(self):
        self.publisher()
        self.assertTrue(wait_until(lambda: json.loads(run("vdisp-probe", "stats", "--once", "--json").stdout)["steps"] > 30))
        result = run("vdisp-probe", "stats", "--once", "--json")
        self.assertEqual(len(result.stdout.splitlines()), 1)
        stages = {s["stage"]: s for s in json.loads(result.stdout)["stages"]}
        self.assertGreater(stages["left"]["runs"], 30)
        self.assertEqual(stages["copy"]["runs"], 0)  # nobody looks at it
        self.assertIn("0 blind", run("vdisp-probe", "stats", "--once").stdout)

    def test_map_once_is_plain_text_with_the_obstacle(self):
        self.publisher()
        result = run("vdisp-probe", "map", "--once")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertNotIn("\x1b", result.stdout)
        lines = result.stdout.splitlines()
        self.assertEqual(len(lines), 28)
        self.assertEqual(sum(line.count("#") for line in lines[:25]), 1)
        self.assertEqual({line.find("#") for line in lines[:25]} - {-1}, {30})  # the publisher's column
        self.assertIn("FRESH", lines[26])
        self.assertRegex(lines[27], r"nearest obstacle \d\.\d\d m away, \d+ deg to the right")

    def test_map_json_holds_the_counts(self):
        self.publisher()
        told = json.loads(run("vdisp-probe", "map", "--once", "--json").stdout)
        self.assertEqual((told["state"], told["columns"], told["rows"], told["cell"]), ("fresh", 51, 50, 0.1))
        self.assertEqual(sum(map(sum, told["counts"])), 100)
        self.assertAlmostEqual(told["nearest"]["x"], 0.5, 5)

    def test_map_refuses_a_stage_that_is_none(self):
        self.publisher()
        self.assert_refused(run("vdisp-probe", "map", "--once", "--stage", "left"), 64, "left", "gray8")
        for once in ([], ["--once"]):
            start = time.monotonic()
            self.assert_refused(run("vdisp-probe", "map", *once, "--stage", "nosuch"), 64, "nosuch", "left copy floor_model map")
            self.assertLess(time.monotonic() - start, 4)

    def test_a_blind_map_says_why_and_shows_no_cell(self):
        self.publisher("--blind")
        result = run("vdisp-probe", "map", "--once")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stdout.strip(), "BLIND: the source delivered no frame in time")
        self.assertIsNone(json.loads(run("vdisp-probe", "map", "--once", "--json").stdout)["nearest"])

    def test_dump_writes_whole_frames_of_one_sequence_each(self):
        self.publisher()
        result = run("vdisp-probe", "dump", self.folder / "out", "--frames", "3", "--picture")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(sorted(p.name for p in (self.folder / "out").iterdir()), ["000000", "000001", "000002"])
        sequences = []
        for n in range(3):
            frame = self.frame(self.folder / "out", n)
            sequences.append(frame["sequence"])
            self.assertEqual(frame["files"], {"left": None, "right": None})  # the daemon knows them, its images do not
            # The publisher writes its sequence into the picture, and its obstacle into that row of the map.
            for stage in ("left", "copy"):
                picture = cv2.imread(str(self.folder / f"out/{n:06d}/{stage}.png"), cv2.IMREAD_UNCHANGED)
                self.assertEqual(picture[100, 100], frame["sequence"] & 255)
            counts = cv2.imread(str(self.folder / f"out/{n:06d}/map.png"), cv2.IMREAD_UNCHANGED)
            self.assertEqual(counts[frame["sequence"] % 50, 30], 100)
            view = cv2.imread(str(self.folder / f"out/{n:06d}/map_view.png"), cv2.IMREAD_UNCHANGED)
            self.assertEqual(view.shape[2], 3)
        self.assertEqual(sequences, sorted(set(sequences)))

    def test_dump_refuses_what_it_cannot_do(self):
        self.publisher()
        self.assert_refused(run("vdisp-probe", "dump", self.folder / "out", "nosuch"), 64, "nosuch", "copy")
        self.assertEqual(run("vdisp-probe", "dump", self.folder / "out", "left").returncode, 0)
        self.assert_refused(run("vdisp-probe", "dump", self.folder / "out", "left"), 73, "000000", "exists")
        self.assertEqual([p.name for p in (self.folder / "out/000000").iterdir() if p.suffix == ".png"], ["left.png"])
        self.assert_refused(run("vdisp-probe", "sheet", "/dev/null/x.png"), 73, "/dev/null/x.png")

    def test_dump_onto_a_full_disk_is_74_and_leaves_whole_frames_only(self):
        self.publisher()
        disk = self.folder / "disk"
        disk.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=300k", "none", disk], check=True)
        self.addCleanup(subprocess.run, ["umount", disk])
        result = run("vdisp-probe", "dump", disk, "--frames", "1000")
        self.assert_refused(result, 74, "No space left")
        frames = sorted(p.name for p in disk.iterdir())
        self.assertTrue(frames)
        for name in frames:
            self.assertTrue((disk / name / "frame.json").exists(), name)

    def test_sheet_is_one_picture_of_all_stages(self):
        self.publisher()
        result = run("vdisp-probe", "sheet", self.folder / "sheet.png")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(cv2.imread(str(self.folder / "sheet.png")).shape[1], 1500)

    def test_live_map_gives_the_terminal_back_on_sigterm_and_on_q(self):
        self.publisher()
        for end in ("SIGTERM", "q"):
            with self.subTest(end=end):
                master, slave = pty.openpty()
                before = termios.tcgetattr(slave)
                probe = subprocess.Popen([BIN / "vdisp-probe", "map"], stdin=slave, stdout=slave, stderr=slave)
                seen = b""
                while b"FRESH" not in seen:
                    seen += os.read(master, 65536)
                self.assertNotEqual(termios.tcgetattr(slave)[3], before[3])
                if end == "q":
                    os.write(master, b"q")
                else:
                    probe.send_signal(signal.SIGTERM)
                while not seen.endswith(b"\x1b[?1049l"):
                    seen += os.read(master, 65536)
                self.assertEqual(probe.wait(5), 0)
                self.assertEqual(termios.tcgetattr(slave), before)
                os.close(master)
                os.close(slave)


class Why(ProgramTest):
    """On the real daemon and the simulator, whose objects and floor are known."""

    def daemon(self, *settings):
        options = [word for setting in ("sim.rate=4", *settings) for word in ("--set", setting)]
        daemon = Running("vdispd", "--sim", *options, stdout=subprocess.DEVNULL)
        self.addCleanup(daemon.__exit__)
        self.assertTrue(wait_until(lambda: run("vdisp-probe", "list").returncode == 0), daemon.text())

    def why(self, *arguments):
        result = run("vdisp-probe", "why", *arguments, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(len(result.stdout.splitlines()), 1)
        return json.loads(result.stdout)

    def dumped(self, *topics):
        """Images and frame.json of one frame; the scene does not move where a test uses it."""
        folder = self.folder / "frame"
        self.assertEqual(run("vdisp-probe", "dump", folder, *topics).returncode, 0)
        images = {topic: cv2.imread(str(folder / "000000" / (topic + ".png")), cv2.IMREAD_UNCHANGED) for topic in topics}
        return images, self.frame(folder, 0)

    def test_an_empty_floor_is_floor_back_to_the_pixels(self):
        self.daemon("sim.scene=empty", "sim.cameraHeight=0.8", "sim.pitch=0.2618")
        told = self.why(29, 25)
        self.assertEqual((told["state"], told["synthetic"]), ("fresh", True))
        cell = told["cell"]
        self.assertEqual((cell["row"], cell["column"], cell["verdict"], cell["points"]), (29, 25, "floor", 0))
        self.assertEqual((cell["x"], cell["z"], cell["bearing_deg"]), (0, 2.05, 0))  # (50 - 29.5) cells of 0.1 m
        self.assertLess(cell["occupancy"], cell["occupied_from"])
        self.assertEqual(told["standing"], {"pixels": 0, "filled": 0})
        # The simulator's own camera.
        floor = told["floor"]
        self.assertAlmostEqual(floor["height_m"], 0.8, delta=0.02)
        self.assertAlmostEqual(floor["pitch_deg"], 15, delta=0.5)
        view = told["view"]
        self.assertGreater(view["surface"]["floor"], 0.9 * view["pixels"])
        self.assertGreater(view["depth"]["as_cell"], 0.9 * view["pixels"])
        self.assertLess(sum(view["rejected"].values()), 0.1 * view["pixels"])
        # And back: the pixel in the middle stands in the cell.
        pixel = self.why(sum(view["rows"]) // 2, sum(view["columns"]) // 2, "--pixel")
        self.assertEqual((pixel["cell"]["row"], pixel["cell"]["column"]), (29, 25))
        self.assertEqual(pixel["pixel"]["surface"], "floor")
        self.assertLess(abs(pixel["pixel"]["height"]), 0.03)
        self.assertAlmostEqual(pixel["pixel"]["disparity"], pixel["pixel"]["floor_disparity"], delta=0.5)
        # The limits are those that hold now.
        self.assertEqual((pixel["pixel"]["max_height"], pixel["pixel"]["clearance"], pixel["pixel"]["because"]), (0.2, 2, None))
        self.assertEqual(run("vdisp-probe", "set", "Limit obstacle.max_height", "0.35").returncode, 0)
        self.assertEqual(self.why(300, 320, "--pixel")["pixel"]["max_height"], 0.35)
        unknown = self.why(300, 320, "--pixel", "--control", self.folder / "nothing")
        self.assertEqual((unknown["pixel"]["max_height"], unknown["pixel"]["surface"]), (None, "floor"))
        # Above the horizon, row 240 - f tan 15 deg, is no floor.
        sky = self.why(5, 320, "--pixel")
        self.assertIsNone(sky["pixel"]["floor_disparity"])
        self.assertNotIn("view", sky)

    def test_an_obstacle_is_led_back_to_as_many_pixels_as_the_map_counts(self):
        self.daemon("sim.scene=obstacles")
        images, frame = self.dumped("map", "occupancy", "truth/map_cells")
        obstacles = (images["occupancy"] >= 65) & (images["occupancy"] <= 100) & (images["truth/map_cells"] == 2)
        rows, columns = obstacles.nonzero()
        self.assertGreater(len(rows), 5)
        found = 0
        for row, column in list(zip(rows, columns))[::max(1, len(rows) // 8)]:
            told = self.why(row, column)
            self.assertEqual(told["standing"]["pixels"], told["cell"]["points"], (row, column))
            if told["cell"]["verdict"] != "obstacle":
                continue  # another frame with other noise
            found += 1
            self.assertGreaterEqual(told["cell"]["occupancy"], 50)
            self.assertGreaterEqual(told["cell"]["points_around"], told["cell"]["points"])
            least, most = told["standing"]["disparities"]
            self.assertLessEqual(least, most)
            pixel = self.why(sum(told["standing"]["rows"]) // 2, sum(told["standing"]["columns"]) // 2, "--pixel")["pixel"]
            if pixel.get("surface") == "obstacle":
                self.assertGreater(pixel["height"], 0.2)  # max_height
        self.assertGreater(found, 3)

    def test_what_was_filled_is_told(self):
        # The front of the near box: no texture, and edges.
        self.daemon("sim.scene=blank")
        told = self.why(200, 250, "--pixel")
        pixel = told["pixel"]
        self.assertEqual((pixel["disparity"], pixel["surface"]), (None, "filled obstacle"))
        self.assertGreater(pixel["filled_disparity"], 10)
        self.assertGreater(pixel["height"], 0.2)
        self.assertEqual(told["cell"]["verdict"], "obstacle")
        told = self.why(told["cell"]["row"], told["cell"]["column"])
        self.assertGreater(told["standing"]["filled"], 10)
        self.assertLessEqual(told["standing"]["filled"], told["standing"]["pixels"])

    def test_words_tell_what_json_tells(self):
        self.daemon("sim.scene=empty")
        told = run("vdisp-probe", "why", 29, 25, "--cell").stdout
        for words in ("synthetic", "row 29  column 25   z 2.05 m  x +0.00 m", "floor: floor is seen", "an obstacle from 65 % on",
                      "an obstacle from 3 on", "no pixel of an obstacle", "its floor lies in rows", "found, camera 0."):
            self.assertIn(words, told)
        told = run("vdisp-probe", "why", 300, 320, "--pixel").stdout
        for words in ("row 300  column 320", "over the local floor", "floor would have", "verdict      floor"):
            self.assertIn(words, told)

    def test_a_blind_frame_says_why_and_gives_no_verdict(self):
        self.daemon("sim.scene=empty", "sim.event=cap")
        told = self.why(29, 25)
        self.assertEqual((told["state"], told["reason"]), ("blind", "too_dark"))
        self.assertNotIn("cell", told)
        told = self.why(300, 320, "--pixel")
        self.assertEqual(told["state"], "blind")
        self.assertIsNone(told["pixel"]["disparity"])
        self.assertNotIn("cell", told)
        self.assertIn("BLIND", run("vdisp-probe", "why", 29, 25).stdout)

    def test_what_cannot_be_explained_is_64_and_says_what_can(self):
        self.assert_refused(run("vdisp-probe", "why", 1), 64, "COLUMN")
        self.assert_refused(run("vdisp-probe", "why", 1, "x"), 64, "x")
        self.assert_refused(run("vdisp-probe", "why", 1, 1, "--cell", "--pixel"), 64, "--pixel")
        self.daemon("sim.scene=empty", "Floor.model=line")
        self.assert_refused(run("vdisp-probe", "why", 1, 1), 64, "'surface'", "[Floor] model", "profile")

    def test_places_outside_the_image_are_64(self):
        self.daemon("sim.scene=empty")
        self.assert_refused(run("vdisp-probe", "why", 50, 0), 64, "row 50", "rows 0 to 49", "columns 0 to 50", "--pixel")
        self.assert_refused(run("vdisp-probe", "why", 0, 640, "--pixel"), 64, "column 640", "columns 0 to 639")
        with open("/dev/full", "w") as full:
            result = subprocess.run([BIN / "vdisp-probe", "why", "1", "1"], stdout=full, stderr=subprocess.PIPE, text=True, timeout=20)
        self.assert_refused(result, 74, "output", "No space left")


@unittest.skipUnless(shutil.which("Xvfb") and shutil.which("xdotool"), "needs Xvfb and xdotool")
class View(ProgramTest):
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

    def do(self, *arguments):
        return subprocess.run(["xdotool", *map(str, arguments)], env=self.display, capture_output=True, text=True).stdout.strip()

    def start(self, *options):
        view = Running("vdisp-probe", "view", "--wait", "10", *options, env=self.display, cwd=self.folder)
        self.addCleanup(view.__exit__)
        self.assertTrue(wait_until(lambda: self.title() != ""), view.text())
        self.do("windowfocus", "--sync", self.do("search", "--name", "x"))
        return view

    def title(self):
        window = self.do("search", "--name", "[0-9]x[0-9]")
        return self.do("getwindowname", window.split()[0]) if window else ""

    def press(self, key, title):
        self.do("key", key)
        self.assertTrue(wait_until(lambda: self.title() == title, 3), f"after {key}: {self.title()}")

    def test_without_a_display_it_is_69_and_names_the_map_in_the_terminal(self):
        with Running("vdisp-publish", stdout=subprocess.DEVNULL):
            self.assertTrue(wait_until(lambda: run("vdisp-probe", "list").returncode == 0))
            plain = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")}
            self.assert_refused(run("vdisp-probe", "view", env=plain), 69, "DISPLAY", "vdisp-probe map")
            self.assert_refused(run("vdisp-probe", "view", env={**plain, "DISPLAY": ":9999"}), 69, "vdisp-probe map")

    def test_a_stage_that_does_not_exist_is_64(self):
        with Running("vdisp-publish", stdout=subprocess.DEVNULL):
            self.assert_refused(run("vdisp-probe", "view", "--wait", "10", "--stage", "nosuch", env=self.display), 64, "nosuch", "left copy")

    def test_arrows_page_through_the_stages_s_saves_and_q_ends(self):
        with Running("vdisp-publish", stdout=subprocess.DEVNULL):
            view = self.start()
            self.press("Down", "copy 640x480")
            self.press("Down", "floor_model 416x1")
            self.press("Down", "map 51x50")
            self.press("Down", "left 640x480")
            self.press("Up", "map 51x50")
            for key in ("c", "t", "t", "question", "question", "space", "space"):
                self.do("key", key)
            time.sleep(0.5)
            self.do("key", "s")
            self.assertTrue(wait_until(lambda: list(self.folder.glob("*.png"))), view.text())
            saved = [p.name for p in self.folder.iterdir()]
            self.assertEqual(len(saved), 1)
            self.assertRegex(saved[0], re.compile(r"^map-\d+\.png$"))
            picture = cv2.imread(str(self.folder / saved[0]))
            self.assertGreater(picture.shape[0], 600)
            self.do("key", "q")
            self.assertEqual(view.process.wait(5), 0, view.text())

    def test_sliders_change_the_running_daemon_and_undo_and_write(self):
        config = self.folder / "vdisp.cfg"
        config.write_text("# mine\n[image source]\nthresh = 10  ; texture\n")
        small = [word for setting in ("sim.width=320", "sim.height=240", "image source.ndisp=32", "sim.rate=20") for word in ("--set", setting)]

        def value(key="thresh"):
            return json.loads(run("vdisp-probe", "get", key, "--json").stdout)["value"]

        def becomes(wanted, key="thresh"):
            self.assertTrue(wait_until(lambda: value(key) == wanted, 5), f"{key} = {value(key)}, not {wanted}")
        with Running("vdispd", "--sim", "-c", config, *small, stdout=subprocess.DEVNULL) as daemon:
            view = self.start("--stage", "disparity")
            live = [key["key"] for key in json.loads(run("vdisp-probe", "get", "--json").stdout) if key["live"]]
            own = [key for key in live if key.startswith("image source.")]
            place = own.index("image source.thresh")
            self.do("key", "plus")  # no panel yet: nothing is changed
            self.do("key", "p")
            time.sleep(1)
            self.assertEqual(value(), "10")
            for _ in range(place):
                self.do("key", "Tab")
            self.do("key", "plus")
            becomes("11")
            self.do("key", "plus")
            becomes("12")
            self.do("key", "minus")
            becomes("11")
            self.do("key", "u")
            becomes("12")
            # The panel is 296 px wide, its rows are 38 px high and begin below 60 px; bars leave 10 px to both sides.
            window = self.do("search", "--name", "[0-9]x[0-9]").split()[0]
            x, y = 960 - 296 + 10, 60 + 38 * place + 27
            self.do("mousemove", "--window", window, x + 3, y, "mousedown", 1)
            for step in range(1, 6):
                self.do("mousemove", "--window", window, x + 276 * step // 10, y)
                time.sleep(0.1)
            self.do("mouseup", 1)
            becomes("20")
            self.do("key", "u")
            becomes("12")  # the whole way is one step
            self.do("key", "w")
            self.assertTrue(wait_until(lambda: "thresh = 12  ; texture" in config.read_text(), 5), config.read_text())
            self.assertIn("thresh: 10 -> 11 (control socket, by process", daemon.text())
            self.do("key", "q")
            self.assertEqual(view.process.wait(5), 0, view.text())

    def test_it_outlives_the_daemon_and_finds_the_next_one(self):
        with Running("vdisp-publish", stdout=subprocess.DEVNULL) as daemon:
            view = self.start("--stage", "map")
            daemon.process.kill()
            daemon.process.wait()
        time.sleep(1.5)
        self.assertIsNone(view.process.poll(), view.text())
        self.do("key", "Up")  # keys work without a daemon
        self.assertTrue(wait_until(lambda: self.title() == "floor_model 416x1", 3))
        self.do("key", "Down")
        with Running("vdisp-publish", stdout=subprocess.DEVNULL):
            def frames_come():
                self.do("key", "s")
                return any(p.name.startswith("map-") for p in self.folder.iterdir())
            self.assertTrue(wait_until(frames_come, 15), view.text())
            view.process.terminate()
            self.assertEqual(view.process.wait(5), 0, view.text())


if __name__ == "__main__":
    isolated_main()
