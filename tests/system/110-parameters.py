#!/usr/bin/python3
"""110: each parameter of the table changes the stage it names, in the direction its help states. A key without a proof fails.

SPDX-License-Identifier: Apache-2.0
"""
import csv
import json
import os
import pathlib
import re
import shutil
import subprocess
import time

import cv2
import numpy

import gige
from drive_proofs import DriveProofs
from programs import BIN, ProgramTest, Running, isolated_main, run, wait_until

# A small scene with everything in it: ground, obstacles near and far, noise.
BASE = ["main.middleware=none", "main.debug=0", "image source.source=sim", "sim.scene=flat", "sim.seed=3", "sim.width=320",
        "sim.height=240", "sim.rate=0", "image source.ndisp=32"]
# Boxes without texture, in the camera's full size.
BLANK = ["sim.scene=blank", "sim.seed=1", "sim.width=640", "sim.height=480", "image source.ndisp=48"]


class Dumped:
    """The last frame of a run."""

    def __init__(self, test, folder, frames):
        self.test, self.folder, self.number = test, folder, frames - 1
        self.json = test.frame(folder, self.number)

    def picture(self, stage):
        image = cv2.imread(str(self.folder / f"{self.number:06d}" / f"{stage}.png"), cv2.IMREAD_UNCHANGED)
        self.test.assertIsNotNone(image, f"{stage} was not dumped: {self.json['stages'].get(stage)}")
        return image

    def line(self, stage):
        return numpy.loadtxt(self.folder / f"{self.number:06d}" / f"{stage}.csv", delimiter=",", skiprows=1, ndmin=2)

    def rejected(self, why):
        return self.json["rejected"]["disparity"][why]

    def floor(self, key):
        return self.json["floor"][key]

    def valid(self, stage):
        return self.json["stages"][stage]["valid"]

    def grid(self, key):
        return self.json["stages"]["map"]["grid"][key]

    def obstacle_cells(self):
        """Occupied cells as map_server reads them."""
        return int((cv2.imread(str(self.folder / f"{self.number:06d}" / "map.pgm"), 0) == 0).sum())


class Parameters(DriveProofs, ProgramTest):
    runs = 0

    def dump(self, *sets, frames=1, base=BASE):
        Parameters.runs += 1
        folder = self.folder / f"run{Parameters.runs}"
        arguments = [word for item in [*base, *sets] for word in ("--set", item)]
        result = run("vdispd", *arguments, "--frames", frames, "--dump", folder)
        self.assertEqual(result.returncode, 0, result.stderr)
        return Dumped(self, folder, frames)

    def rises(self, key, values, measure, *sets, frames=1):
        """measure(run) grows strictly with the values of the key."""
        found = [measure(self.dump(*sets, f"{key}={value}", frames=frames)) for value in values]
        for a, b in zip(found, found[1:]):
            self.assertLess(a, b, f"{key} = {values}: {found}")

    def falls(self, key, values, measure, *sets, frames=1):
        self.rises(key, values, lambda dumped: -measure(dumped), *sets, frames=frames)

    # [main]
    def test_main_middleware(self):
        for value, files in (("shm", True), ("ddx", True), ("none", False)):
            with Running("vdispd", "--sim", "--set", f"main.middleware={value}", "--frames", "10000"):
                self.assertEqual(wait_until(lambda: run("vdisp-probe", "list").returncode == 0, 5 if files else 1.5), files, value)

    def test_main_period(self):
        times = []
        for period in (0, 2000):
            begin = time.monotonic()
            self.dump(f"main.period={period}", frames=4)
            times.append(time.monotonic() - begin)
        self.assertGreater(times[1], 6)  # three pauses
        self.assertGreater(times[1], times[0])

    def test_main_debug(self):
        def words(level, *sets):
            return len(run("vdispd", "--sim", "--frames", "3", "--set", "main.middleware=none", "--set", f"main.debug={level}", *sets).stderr)
        lost = ("--set", "Floor.minRansac=100000")
        self.assertLess(words(0, *lost), words(1, *lost))
        self.assertLess(words(1), words(2))
        self.assertLess(words(2), words(3))

    def test_main_name(self):
        with Running("vdispd", "--sim", "--set", "main.name=other"):
            self.assertTrue(wait_until(lambda: run("vdisp-probe", "list", "--name", "other").returncode == 0, 5))
            self.assertEqual(run("vdisp-probe", "list").returncode, 69)

    def test_main_threads(self):
        sets = [word for item in [*self.pairs(640, 480), "image source.source=files", "image source.loop=yes", "main.middleware=none"]
                for word in ("--set", item)]
        def grows_to(count, threads):
            with Running("vdispd", *sets, "--set", f"main.threads={count}") as daemon:
                return wait_until(lambda: len(os.listdir(f"/proc/{daemon.process.pid}/task")) >= threads, 3)
        if os.cpu_count() > 1:  # on one core more threads show nothing
            self.assertFalse(grows_to(1, 4))  # the loop, the log and the parameters
            self.assertTrue(grows_to(4, 4))
        one, four = (self.dump(f"main.threads={count}") for count in (1, 4))
        numpy.testing.assert_array_equal(one.picture("disparity"), four.picture("disparity"))

    def test_main_detectors(self):
        branches = {"map": "vdisparity", "snow": "snow", "cross_check": "both", "decision": "any", "disparity": "all"}
        for detectors, there in (("vdisparity", {"vdisparity", "any"}), ("snow", {"snow", "any"}), ("none", set()),
                                 ("vdisparity, snow", {"vdisparity", "snow", "both", "any"}), ("snow,vdisparity", {"vdisparity", "snow", "both", "any"})):
            stages = self.snow(f"main.detectors={detectors}").json["stages"]
            self.assertEqual({stage for stage in branches if stage in stages}, {s for s, branch in branches.items() if branch in there | {"all"}}, detectors)

    def scheduled(self, *sets):
        """{name of a thread: (policy, real-time priority, processors)} of the running daemon, and what it has locked (kB)."""
        words = [word for item in [*BASE, "main.threads=2", *sets] for word in ("--set", item)]
        with Running("vdispd", *words) as daemon:
            self.assertTrue(wait_until(lambda: "ready" in daemon.text()), daemon.text())
            threads = {}
            for task in pathlib.Path(f"/proc/{daemon.process.pid}/task").iterdir():
                number = int(task.name)
                name = "loop" if number == daemon.process.pid else (task / "comm").read_text().strip() + task.name
                threads[name] = (os.sched_getscheduler(number), os.sched_getparam(number).sched_priority, os.sched_getaffinity(number))
            locked = int(re.search(r"VmLck:\s*(\d+)", pathlib.Path(f"/proc/{daemon.process.pid}/status").read_text())[1])
        return threads, locked

    def real_time(self, *sets):
        threads, _ = self.scheduled("main.debug=1", *sets)
        return [policy[:2] for policy in threads.values() if policy[0] != os.SCHED_OTHER], threads["loop"][:2]

    def refused_to_nobody(self, *words):
        """What vdispd says to a user without rights."""
        # That user need not see the build; /tmp is this test's own, and holds sockets by the names of programs.
        place = pathlib.Path("/tmp/programs")
        place.mkdir(exist_ok=True)
        for name in ("vdispd", "vdisp_sim.so"):
            shutil.copy(BIN / name, place)
        return subprocess.run(["setpriv", "--reuid", "65534", "--regid", "65534", "--clear-groups", "prlimit", "--rtprio=0", "--memlock=65536",
                               place / "vdispd", *[word for item in [*BASE, *words] for word in ("--set", item)], "--frames", "1"],
                              capture_output=True, text=True, timeout=60)

    def test_main_scheduling(self):
        self.assertEqual(self.real_time("main.scheduling=other"), ([], (os.SCHED_OTHER, 0)))
        for word, policy in (("fifo", os.SCHED_FIFO), ("rr", os.SCHED_RR)):
            threads, loop = self.real_time(f"main.scheduling={word}")
            self.assertEqual(loop, (policy, 10))
            self.assertGreaterEqual(threads.count((policy, 10)), 2, threads)  # the loop and its second band
        everything, _ = self.scheduled("main.scheduling=fifo", "main.debug=1")
        self.assertIn(os.SCHED_OTHER, [policy for policy, _, _ in everything.values()])  # the log
        # What works beside the loop would keep it waiting, were it of its priority.
        everything, _ = self.scheduled("main.scheduling=fifo", "main.debug=1", f"main.metrics={self.folder}/m.prom", "recorder.seconds=1", f"recorder.folder={self.folder}/flight")
        for name in ("metrics", "flight", "parameters"):
            found = [policy for thread, (policy, _, _) in everything.items() if thread.startswith(name)]
            self.assertEqual(found, [os.SCHED_OTHER], (name, everything))
        self.assert_refused(self.refused_to_nobody("main.scheduling=fifo"), 77, "[main] scheduling = fifo", "LimitRTPRIO")

    def test_main_priority(self):
        for priority in (3, 40):
            self.assertEqual(self.real_time("main.scheduling=rr", f"main.priority={priority}")[1], (os.SCHED_RR, priority))

    def test_main_cpus(self):
        mine = sorted(os.sched_getaffinity(0))
        for text, cpus in ((str(mine[-1]), {mine[-1]}), (f"{mine[0]} , {mine[-1]}", {mine[0], mine[-1]}), ("", set(mine))):
            threads, _ = self.scheduled(f"main.cpus={text}", "main.debug=1")
            # All but the log, which was there before.
            self.assertEqual([name for name, (_, _, where) in threads.items() if where != cpus and not name.startswith("vdispd")], [], text)
        self.assert_refused(run("vdispd", "--sim", "--set", "main.cpus=1000"), 78, "[main] cpus = 1000", "processor 1000", str(mine[0]))
        for text in ("x", "3-1", "1,", "-1", "0-5000"):
            self.assert_refused(run("vdispd", "--sim", "--set", f"main.cpus={text}"), 78, "main.cpus", "as 0,2-3")

    def test_main_lockMemory(self):
        self.assertLess(self.scheduled("main.lockMemory=no", "main.debug=1")[1], 1000)
        self.assertGreater(self.scheduled("main.lockMemory=yes", "main.debug=1")[1], 20000)
        self.assert_refused(self.refused_to_nobody("main.lockMemory=yes"), 77, "[main] lockMemory = yes", "LimitMEMLOCK")
    def test_main_deadline(self):
        # The pair's way through the tree takes longer than a hundredth of a millisecond, and less than a minute.
        misses = {}
        for deadline in (0.01, 60000):
            with Running("vdispd", "--sim", "--set", f"main.deadline={deadline}", "--set", "sim.rate=20", "--set", "sim.width=320",
                         "--set", "sim.height=240"):
                def health():
                    told = run("vdisp-probe", "stats", "--once", "--json")
                    return json.loads(told.stdout)["health"] if told.returncode == 0 else {}
                self.assertTrue(wait_until(lambda: health().get("frames", 0) > 10, 15))
                misses[deadline] = health()["deadline_misses"]
                self.assertEqual(health()["deadline_ms"], deadline)
        self.assertGreater(misses[0.01], 10)
        self.assertEqual(misses[60000], 0)

    def test_main_metrics(self):
        file = self.folder / "vdisp.prom"
        self.dump(f"main.metrics={file}")
        self.assertIn("vdisp_up", file.read_text())
        self.assert_refused(run("vdispd", "--sim", "--set", "main.metrics=/dev/null/x", "--frames", 1), 73, "/dev/null/x")

    # [image source]
    def files(self, *sets, frames=1):
        return self.dump(*sets, frames=frames, base=["main.middleware=none", "main.debug=0", "image source.ndisp=32",
                                                     "image source.source=files"])

    def pairs(self, width=320, height=240):
        folder = self.write_pairs(3, width, height)
        return [f"image source.left={folder}/left/%06d.png", f"image source.right={folder}/right/%06d.png"]

    def test_image_source_source(self):
        self.assertEqual(self.files(*self.pairs()).json["files"], {"left": "000000.png", "right": "000000.png"})
        self.assertNotIn("000000.png", str(self.dump().json.get("files")))

    def test_image_source_left_and_right(self):
        left, right = self.pairs()
        first = cv2.imread(str(self.folder / "left" / "000000.png"), 0)
        second = cv2.imread(str(self.folder / "right" / "000000.png"), 0)
        dumped = self.files(left, right)
        numpy.testing.assert_array_equal(dumped.picture("camera/left"), first)
        numpy.testing.assert_array_equal(dumped.picture("camera/right"), second)
        dumped = self.files(left.replace("/left/", "/right/"), right.replace("/right/", "/left/"))
        numpy.testing.assert_array_equal(dumped.picture("camera/left"), second)

    def test_image_source_rate(self):
        self.assertEqual(self.files(*self.pairs(), "image source.rate=10", frames=2).json["timestamp_ns"], 100_000_000)
        self.assertEqual(self.files(*self.pairs(), "image source.rate=50", frames=2).json["timestamp_ns"], 20_000_000)

    def test_image_source_loop(self):
        steps = {}
        for loop in ("no", "yes"):
            sets = [word for item in [*self.pairs(), "main.middleware=none", "image source.source=files", "image source.ndisp=32",
                                      f"image source.loop={loop}"] for word in ("--set", item)]
            steps[loop] = re.search(r"(\d+) steps", run("vdispd", *sets, "--frames", 7).stderr).group(1)
        self.assertEqual(steps, {"no": "3", "yes": "7"})

    def test_image_source_paramfile(self):
        pairs = self.pairs()
        matrix = "!!opencv-matrix\n   rows: 3\n   cols: 4\n   dt: d\n   data: [ 200., 0., 160., {}, 0., 200., 120., 0., 0., 0., 1., 0. ]\n"
        (self.folder / "c.yml").write_text("%YAML:1.0\n---\nimage_width: 320\nimage_height: 240\nP1: " + matrix.format("0.") + "P2: " +
                                           matrix.format("-20."))
        self.assertNotIn("camera", self.files(*pairs).json["stages"]["left"])
        self.assertFalse(self.files(*pairs).valid("map"))
        calibrated = self.files(*pairs, f"image source.paramfile={self.folder}/c.yml")
        self.assertAlmostEqual(calibrated.json["stages"]["left"]["camera"]["baseline"], 0.1, 6)

    def test_image_source_width_and_height(self):
        self.files(*self.pairs(), "image source.width=320", "image source.height=240")
        for wrong in ("image source.width=300", "image source.height=300"):
            with self.assertRaisesRegex(AssertionError, "78"):
                self.files(*self.pairs(), wrong)

    def test_image_source_bayer(self):
        # A grey scene under a colour cast: only the right order of the mosaic's colours gives it back.
        grey = numpy.random.default_rng(2).integers(40, 250, (240 // 8, 320 // 8)).repeat(8, 0).repeat(8, 1)
        colours = {"r": grey, "g": grey * 0.6, "b": grey * 0.3}
        luma = 0.299 * colours["r"] + 0.587 * colours["g"] + 0.114 * colours["b"]
        flat = numpy.zeros(grey.shape, bool)  # pixels whose neighbours are in the same square
        for i in range(1, 7):
            for j in range(1, 7):
                flat[i::8, j::8] = True
        for side in ("left", "right"):
            (self.folder / side).mkdir()
        orders = ("rggb", "bggr", "grbg", "gbrg")
        for order in orders:
            mosaic = numpy.empty(grey.shape)
            for i, letter in enumerate(order):
                mosaic[i // 2::2, i % 2::2] = colours[letter][i // 2::2, i % 2::2]
            mosaic = numpy.rint(mosaic).astype(numpy.uint8)
            for side in ("left", "right"):
                cv2.imwrite(str(self.folder / side / "000000.png"), mosaic)
            pair = [f"image source.{side}={self.folder}/{side}/%06d.png" for side in ("left", "right")]
            numpy.testing.assert_array_equal(self.files(*pair).picture("left"), mosaic)
            for said in orders:
                dumped = self.files(*pair, f"image source.bayer={said}")
                numpy.testing.assert_array_equal(dumped.picture("camera/left"), mosaic)
                for stage in ("left", "right"):
                    error = numpy.abs(dumped.picture(stage) - luma)[flat].max()
                    self.assertEqual(error <= 1, said == order, (order, said, error))

    def test_image_source_smooth(self):
        for matcher in ("bm", "census", "opencv"):
            for word in ("mean", "median"):
                self.rises("image source.smooth", ["none", word], lambda d: d.rejected("measured"), "sim.noise=10",
                           f"image source.matcher={matcher}")

        sharp, smoothed = (self.dump("image source.matcher=sgm", f"image source.smooth={word}").picture("disparity") for word in ("none", "mean"))
        self.assertTrue((sharp != smoothed).any())

    def test_image_source_prefilter(self):
        self.rises("image source.prefilter", ["sobel", "log"], lambda d: d.rejected("measured"), "sim.texture=0.3")

    def test_image_source_census(self):
        self.rises("image source.census", ["3x3", "5x5"], lambda d: d.rejected("measured"), "image source.matcher=census")

    def test_image_source_align(self):
        """A floor seen at a flat angle, half a px of disparity a row."""
        flat = ["sim.cameraHeight=0.15", "sim.pitch=0.1", "mounting.height=0.15", "mounting.pitch=0.1", "sim.scene=empty"]
        for matcher in ("bm", "census"):
            self.rises("image source.align", ["none", "floor"], lambda d: d.rejected("measured"), *flat, f"image source.matcher={matcher}")

    def test_image_source_matcher(self):
        self.rises("image source.matcher", ["bm", "census"], lambda d: d.rejected("measured"), "sim.gain=1.6")
        dense = "sim.scene=empty"
        self.assertGreater(self.dump(dense, "image source.matcher=opencv-sgbm").rejected("measured"),
                           self.dump(dense, "image source.matcher=opencv").rejected("measured"))

        self.assertGreater(self.dump(dense, "image source.matcher=sgm").rejected("measured"),
                           self.dump(dense, "image source.matcher=bm", "sim.texture=0.3").rejected("measured"))

    def test_image_source_paths(self):
        """Each number of paths finds something else; none is better everywhere."""
        noisy = ["image source.matcher=sgm", "sim.noise=12", "image source.unique=0"]
        pictures = [self.dump(f"image source.paths={paths}", *noisy).picture("disparity") for paths in (3, 4, 8)]
        self.assertTrue((pictures[0] != pictures[1]).any() and (pictures[1] != pictures[2]).any())

    def test_image_source_ndisp(self):
        self.rises("image source.ndisp", [32, 64], lambda d: d.picture("vdisparity").shape[1])
        self.rises("image source.ndisp", [16, 32], lambda d: d.picture("disparity").max())

    def test_image_source_minDisparity(self):
        self.assertGreaterEqual(self.least_disparity(self.dump("image source.minDisparity=12")), 11 * 16)
        self.assertLess(self.least_disparity(self.dump()), 11 * 16)

    def least_disparity(self, dumped):
        disparity = dumped.picture("disparity")
        return disparity[disparity > 0].min()

    def test_image_source_corrsize(self):
        self.falls("image source.corrsize", [5, 7, 9], lambda d: d.rejected("not_unique") + d.rejected("left_right"), "sim.noise=8",
                   "image source.align=none")

    def test_image_source_thresh(self):
        self.rises("image source.thresh", [0, 20, 40], lambda d: d.rejected("low_texture"), "sim.texture=0.2")

    def test_image_source_unique(self):
        self.rises("image source.unique", [0, 10, 40], lambda d: d.rejected("not_unique"))

    def test_image_source_SpeckleSize(self):
        self.rises("image source.SpeckleSize", [0, 100, 2000], lambda d: d.rejected("speckle"))

    def test_image_source_SpeckleDiff(self):
        self.falls("image source.SpeckleDiff", [0, 1, 4], lambda d: d.rejected("speckle"))

    # [camera]: two GigE cameras that are programs, with pictures that are known
    CAMERAS = {"main.middleware": "none", "main.debug": 0, "main.detectors": "none", "image source.source": "aravis", "image source.ndisp": 32,
               "image source.width": 160, "image source.height": 120, "image source.rate": 50, "camera.left": "LEFT01", "camera.right": "RIGHT02"}

    def cameras(self, *pictures, late_ms=0):
        """Two; with no pictures of two different textures. Returns the pictures."""
        random = numpy.random.default_rng(5)
        pictures = pictures or [random.integers(0, 120, (120, 160), numpy.uint8) for _ in range(2)]
        for address, serial, picture, late in zip((gige.LEFT, gige.RIGHT), ("LEFT01", "RIGHT02"), pictures, (0, late_ms)):
            gige.GigeCamera(self, address, serial, picture, late_ms=late)
        return pictures

    def live(self, *sets, frames=6):
        """What they deliver. Exposure and gain as the pictures are, where nothing else is said."""
        plain = [] if any("exposeBy" in item for item in sets) else ["camera.exposeBy=fixed"]
        dumped = self.dump(*plain, *sets, frames=frames, base=[f"{key}={value}" for key, value in self.CAMERAS.items()])
        for number in reversed(range(frames)):  # the last one with a pair: on a busy machine a step may have none
            if self.frame(dumped.folder, number)["valid"]:
                dumped.number, dumped.json = number, self.frame(dumped.folder, number)
                break
        return dumped

    def assert_seen(self, dumped, left, right):
        """All rows but the first, which holds the time."""
        numpy.testing.assert_array_equal(dumped.picture("camera/left")[1:], left[1:])
        numpy.testing.assert_array_equal(dumped.picture("camera/right")[1:], right[1:])

    def status(self, dumped, *path):
        found = dumped.json["camera_status"]
        for word in path:
            found = found[word]
        return found

    def test_camera_left_and_right(self):
        left, right = self.cameras()
        self.assert_seen(self.live("camera.left=LEFT01", "camera.right=RIGHT02"), left, right)
        self.assert_seen(self.live("camera.left=RIGHT02", "camera.right=LEFT01"), right, left)
        self.assert_seen(self.live(f"camera.left={gige.RIGHT}", "camera.right=Aravis-Fake-LEFT01"), right, left)
        self.assert_seen(self.live("camera.left=", "camera.right="), left, right)
        self.assert_seen(self.live("camera.left=", "camera.right=LEFT01"), right, left)

    def test_camera_views(self):
        both = self.cameras(numpy.random.default_rng(6).integers(0, 120, (120, 320), numpy.uint8))[0]
        self.assert_seen(self.live("camera.views=beside"), both[:, :160], both[:, 160:])
        self.assert_seen(self.live("camera.views=turns"), both[:, ::2], both[:, 1::2])
        self.assertFalse(self.live("camera.views=one").valid("camera/left"))  # then it is half a pair

    def test_camera_swap(self):
        # One texture, seen 16 px apart: what is near lies farther right in the left view.
        world = cv2.resize(numpy.random.default_rng(7).integers(0, 120, (30, 44), numpy.uint8), (176, 120), interpolation=cv2.INTER_CUBIC)
        left, right = numpy.ascontiguousarray(world[:, :160]), numpy.ascontiguousarray(world[:, 16:])
        self.cameras(left, right)
        self.assert_seen(self.live("camera.swap=no"), left, right)
        self.assert_seen(self.live("camera.swap=yes"), right, left)
        for sets, exchanged in (([], False), (["camera.left=RIGHT02", "camera.right=LEFT01"], True)):
            found = self.live("camera.swap=auto", *sets, frames=20)
            self.assert_seen(found, left, right)
            self.assertEqual(self.status(found, "exchanged"), exchanged)

    def test_camera_pixels(self):
        left, right = self.cameras()
        for word, sets, code in (("auto", [], "gray8"), ("gray16", [], "gray16"), ("rgb8", [], "rgb8"),
                                 ("bayer8", ["image source.bayer=bggr"], "bggr"), ("auto", ["image source.bayer=rggb"], "rggb")):
            self.assert_seen(self.live(f"camera.pixels={word}", *sets), left, right)
            self.assertEqual([gige.CODES.get(gige.register(address, gige.PIXELS)) for address in (gige.LEFT, gige.RIGHT)], [code] * 2, word)
        for word in ("gray10", "gray12", "yuyv", "uyvy", "jpeg"):  # what these become is tests/unit/live_test's
            with self.assertRaisesRegex(AssertionError, f"pixels = {word} cannot be had; it has gray8, gray16"):
                self.live(f"camera.pixels={word}")

    def test_camera_trigger(self):
        self.cameras()
        def registers():
            return [gige.register(address, what) for address in (gige.LEFT, gige.RIGHT) for what in (gige.TRIGGER_MODE, gige.TRIGGER_SOURCE)]
        self.assertTrue(self.live("camera.trigger=free").valid("camera/left"))
        self.assertEqual(registers()[::2], [0, 0])
        self.assertTrue(self.live("camera.trigger=software").valid("camera/left"))
        self.assertEqual(registers(), [1, 1, 1, 1])
        waiting = self.live("camera.trigger=line")  # nobody gives a signal
        self.assertEqual(waiting.json["reason"], "no_frame")
        self.assertEqual(registers(), [1, 0, 1, 0])

    def unpaired(self, dumped):
        return self.status(dumped, "right", "unpaired") + self.status(dumped, "left", "unpaired")

    def in_some_run(self, proof, runs=8):
        """Where a busy machine holds up one of two cameras that are programs, the moments at which they send prove nothing: then once more.
        What a pair is, is proved without clocks by tests/unit/frame_pairs_test.cpp."""
        for left in reversed(range(runs)):
            try:
                return proof()
            except AssertionError:
                if left == 0:
                    raise

    def test_camera_tolerance(self):
        self.cameras(late_ms=8)  # every other frame of the right one
        self.in_some_run(lambda: self.falls("camera.tolerance", [4, 15], self.unpaired,
                                            *(f"{key}={value}" for key, value in self.CAMERAS.items()), frames=40))

    def test_camera_pairing(self):
        self.cameras(late_ms=8)
        self.in_some_run(lambda: self.falls("camera.pairing", ["time", "count"], self.unpaired, "camera.tolerance=5",
                                            *(f"{key}={value}" for key, value in self.CAMERAS.items()), frames=40))

    def light(self):
        return [gige.register(gige.LEFT, what) for what in (gige.EXPOSURE, gige.GAIN)]

    def test_camera_exposeBy(self):
        self.cameras(*[numpy.full((120, 160), 128, numpy.uint8)] * 2)
        dumped = self.live("camera.exposeBy=camera")
        self.assertEqual(gige.register(gige.LEFT, gige.GAIN_AUTO), 2)  # continuous; it has no automatic exposure
        self.assertIsNone(self.status(dumped, "left", "exposure_us"))
        dumped = self.live("camera.exposeBy=fixed", "camera.exposure=1000")
        self.assertEqual(gige.register(gige.LEFT, gige.GAIN_AUTO), 1)
        self.assertEqual(self.light(), [1000, 0])
        self.assertLess(self.status(dumped, "left", "floor_level"), 30)
        for exposure in (500, 15000):
            dumped = self.live("camera.exposeBy=floor", f"camera.exposure={exposure}", frames=60)
            self.assertAlmostEqual(self.status(dumped, "left", "floor_level"), 110, delta=15)
            self.assertEqual(self.light(), [gige.register(gige.RIGHT, what) for what in (gige.EXPOSURE, gige.GAIN)])

    def test_camera_exposure(self):
        self.cameras()
        dumped = [self.live(f"camera.exposure={value}") for value in (2000, 5000)]
        self.assertEqual([self.status(d, "left", "exposure_us") for d in dumped], [2000, 5000])
        self.assertLess(dumped[0].picture("camera/left").mean(), dumped[1].picture("camera/left").mean())

    def test_camera_longestExposure(self):
        self.cameras(*[numpy.full((120, 160), 40, numpy.uint8)] * 2)
        lights = []
        for longest in (6000, 15000):
            self.live("camera.exposeBy=floor", f"camera.longestExposure={longest}", frames=60)
            lights.append(self.light())
        self.assertEqual(lights[0][0], 6000)
        self.assertGreater(lights[0][1], 4)  # dB
        self.assertGreater(lights[1][0], 12000)
        self.assertEqual(lights[1][1], 0)

    def test_camera_gain(self):
        self.cameras()
        dumped = [self.live(f"camera.gain={value}") for value in (0, 6)]
        self.assertEqual([self.status(d, "left", "gain_db") for d in dumped], [0, 6])
        self.assertLess(dumped[0].picture("camera/left").mean(), 0.6 * dumped[1].picture("camera/left").mean())

    def test_camera_packetSize(self):
        self.cameras()
        for size in (576, 8192):
            self.assertTrue(self.live(f"camera.packetSize={size}").valid("camera/left"))
            self.assertEqual([gige.register(address, gige.PACKET_SIZE) & 0xffff for address in (gige.LEFT, gige.RIGHT)], [size, size])
        self.live("camera.packetSize=0")
        self.assertNotIn(gige.register(gige.LEFT, gige.PACKET_SIZE) & 0xffff, (576,))

    def test_image_source_rowLimit(self):
        self.rises("image source.rowLimit", (0.5, 2), lambda run: run.json["row_error"]["limit_px"])
        left, right = (self.folder / side for side in ("left", "right"))
        random = numpy.random.default_rng(5)
        texture = cv2.GaussianBlur(random.integers(0, 255, (243, 340), numpy.uint8), (0, 0), 1.5)
        texture = cv2.normalize(texture, None, 0, 255, cv2.NORM_MINMAX)
        for folder, view in ((left, texture[1:241, 10:330]), (right, texture[0:240, 20:340])):  # right: a row lower, 10 px to the left
            folder.mkdir()
            for i in range(30):
                cv2.imwrite(str(folder / f"{i:06d}.png"), view)
        files = [f"image source.left={left}/%06d.png", f"image source.right={right}/%06d.png", "image source.source=files", "image source.ndisp=32",
                 "image source.rate=30", "main.middleware=none", "main.debug=1"]
        for limit, state in ((0.5, "drifted"), (2, "good")):
            told = self.dump(f"image source.rowLimit={limit}", base=files, frames=30).json["row_error"]
            self.assertEqual(told["state"], state, told)
            self.assertAlmostEqual(told["shift_px"], 1, delta=0.05)

    # [mounting]
    def test_mounting_height_and_heightTolerance(self):
        self.assertFalse(self.dump("mounting.height=0.8").floor("mounting_differs"))
        self.assertTrue(self.dump("mounting.height=1.2").floor("mounting_differs"))
        self.assertFalse(self.dump("mounting.height=1.2", "mounting.heightTolerance=0.5").floor("mounting_differs"))

    def test_mounting_pitch_and_pitchTolerance(self):
        self.assertFalse(self.dump("mounting.pitch=0.26").floor("mounting_differs"))
        self.assertTrue(self.dump("mounting.pitch=0.5").floor("mounting_differs"))
        self.assertFalse(self.dump("mounting.pitch=0.5", "mounting.pitchTolerance=0.5").floor("mounting_differs"))

    def test_mounting_roll(self):
        # Everything in this view lies below the optical axis or little above: undoing a roll to the right moves it to the left.
        def middle(dumped):
            cells = dumped.picture("map").astype(float)
            return (cells.sum(0) @ numpy.arange(cells.shape[1])) / cells.sum()
        self.falls("mounting.roll", [0, 0.3, 0.6], middle, "sim.pitch=-0.1", "Limit obstacle.angRot=-0.1", "sim.scene=obstacles", "Floor.model=line")

    def test_mounting_yaw_x_and_y(self):
        pose = self.dump("mounting.x=0.5", "mounting.y=-0.25", "mounting.yaw=0.125").grid("pose")
        self.assertEqual(pose, [0.5, -0.25, 0.125])
        self.assertEqual(self.dump().grid("pose"), [0, 0, 0])

    # [Floor]
    def test_floor_model(self):
        for model in ("line", "plane", "profile"):
            self.assertEqual(self.dump(f"Floor.model={model}").floor("model"), model)
        # A bank is nothing to the line, and ground that rises is nothing to the plane.
        self.assertIsNone(self.dump("Floor.model=line", "sim.roll=0.15").floor("roll_rad"))
        self.assertAlmostEqual(self.dump("Floor.model=plane", "sim.roll=0.15").floor("roll_rad"), 0.15, delta=0.01)
        ramp = ("sim.scene=empty", "sim.ground=ramp", "sim.slope=0.2")
        self.assertEqual(self.dump("Floor.model=plane", *ramp).floor("profile"), [])
        self.assertGreater(max(step["height_m"] for step in self.dump("Floor.model=profile", *ramp).floor("profile")), 0.2)

    def test_floor_hold(self):
        # The light goes on and off: nothing is held in the dark; a floor that is only hard to find is held for so long.
        def held(seconds):
            dumped = self.dump(f"Floor.hold={seconds}", "sim.scene=empty", "sim.event=dark", "sim.eventFrame=2", frames=4)
            return [self.frame(dumped.folder, i)["floor"]["state"] for i in range(4)]
        self.assertEqual(held(5)[1:], ["found", "lost", "lost"])
        # Between two frames of a floor one of a wall that fills the view: 20 px everywhere, from 1.3 m ahead.
        golden = pathlib.Path(__file__).resolve().parents[1] / "golden"
        wall = numpy.random.default_rng(1).integers(0, 255, (240, 360), numpy.uint8)
        for side, shift in (("left", 0), ("right", 20)):
            (self.folder / side).mkdir(exist_ok=True)
            for i, picture in enumerate((cv2.imread(str(golden / side / "000000.png"), 0), wall[:, shift:shift + 320],
                                         cv2.imread(str(golden / side / "000002.png"), 0))):
                cv2.imwrite(str(self.folder / side / f"{i}.png"), picture)
        files = ["main.middleware=none", "main.debug=0", "image source.source=files", f"image source.left={self.folder}/left/%d.png",
                 f"image source.right={self.folder}/right/%d.png", f"image source.paramfile={golden}/calibration.yml",
                 "image source.rate=10", "image source.ndisp=32", "mounting.height=0.8"]
        def bridged(seconds):
            dumped = self.dump(f"Floor.hold={seconds}", frames=3, base=files)
            return [self.frame(dumped.folder, i)["floor"]["state"] for i in range(3)]
        self.assertEqual(bridged(1), ["found", "held", "found"])
        self.assertEqual(bridged(0), ["found", "lost", "found"])

    def test_floor_maxSlope(self):
        # A ramp of 0.25 rad is floor to one who climbs it, and in the way of who does not.
        self.falls("Floor.maxSlope", [0.05, 0.4], lambda d: (d.picture("occupancy") >= 65).sum() - (d.picture("occupancy") == 255).sum(),
                   "sim.scene=empty", "sim.ground=ramp", "sim.slope=0.25")

    def test_floor_minVotes(self):
        self.falls("Floor.minVotes", [0, 3, 10], lambda d: d.floor("points"), "Floor.model=line")

    def test_floor_minRansac(self):
        self.assertEqual(self.dump("Floor.model=line", "Floor.minRansac=100").floor("state"), "found")
        lost = self.dump("Floor.model=line", "Floor.minRansac=100000")
        self.assertEqual((lost.floor("state"), lost.json["reason"], lost.valid("map")), ("lost", "few_points", False))

    def test_floor_iterRansac(self):
        # The draws of a frame are the same: more of them never find a line with fewer points, and among many frames some with more.
        def points(iterations):
            dumped = self.dump("Floor.model=line", "sim.scene=obstacles", "sim.noise=12", "Floor.distThres=1", f"Floor.iterRansac={iterations}", frames=6)
            return sum(self.frame(dumped.folder, i)["floor"]["points"] for i in range(6))
        self.assertLess(points(10), points(400))

    def test_floor_anglefloorMin(self):
        self.assertEqual(self.dump("Floor.model=line", "Floor.anglefloorMin=0.3").floor("state"), "found")
        above = self.dump("Floor.model=line", "Floor.anglefloorMin=1.2", "Floor.anglefloorMax=1.5")
        self.assertTrue(above.floor("state") == "lost" or above.floor("a") > numpy.tan(1.2))

    def test_floor_anglefloorMax(self):
        self.assertEqual(self.dump("Floor.model=line", "Floor.anglefloorMax=0.7").floor("state"), "found")
        below = self.dump("Floor.model=line", "Floor.anglefloorMax=0.2")
        self.assertTrue(below.floor("state") == "lost" or below.floor("a") < numpy.tan(0.2))

    def test_floor_distThres(self):
        self.rises("Floor.distThres", [0.5, 2, 8], lambda d: d.floor("points"), "Floor.model=line")

    # [Limit obstacle]
    def test_limit_obstacle_max_height(self):
        self.falls("Limit obstacle.max_height", [0.1, 0.2, 0.4], lambda d: (d.picture("obstacles") > 0).sum())
        self.falls("Limit obstacle.max_height", [0.1, 0.2, 0.4], lambda d: d.line("limit")[300, 1])

    def test_limit_obstacle_clearance(self):
        # A beam at 1.2 m and more is in the way of who is higher than that.
        self.rises("Limit obstacle.clearance", [0.9, 3], lambda d: (d.picture("obstacles") > 0).sum(), "sim.scene=overhangs", "sim.pitch=0.1")

    def test_limit_obstacle_fill(self):
        # A narrow face and a wide one have edges and no texture; 0 fills none.
        self.rises("Limit obstacle.fill", [0, 0.4, 2], lambda d: d.json["stages"]["surface"]["filled"], *BLANK)
        dumped = self.dump("Limit obstacle.fill=2", *BLANK)
        surface, number = dumped.picture("surface"), dumped.picture("truth/object")
        self.assertGreater(((number > 0) & (number < 255))[surface == 5].mean(), 0.97)  # of the boxes, not of floor and sky

    def test_limit_obstacle_and_map_angRot(self):
        self.falls("Limit obstacle.angRot", [0, 0.26, 0.8], lambda d: d.line("limit")[300, 1], "Floor.model=line")
        # What lies below the axis is taken to be nearer, the more the camera is taken to look down.
        def distance(dumped):
            cells = dumped.picture("map").astype(float)
            return (cells.sum(1) @ (50 - numpy.arange(50))) / cells.sum()
        self.falls("Map.angRot", [0.3, 0.5, 0.8], distance, "sim.scene=obstacles", "Floor.model=line")
        self.assertFalse(numpy.array_equal(self.dump("Map.angRot=auto", "sim.pitch=0.4", "Floor.model=line").picture("map"),
                                           self.dump("Map.angRot=0.1", "sim.pitch=0.4", "Floor.model=line").picture("map")))

    # [Map]
    def test_map_range(self):
        self.rises("Map.range", [3, 5, 20], lambda d: d.picture("map").shape[0])

    def test_map_width(self):
        self.rises("Map.width", [3, 5.1, 20], lambda d: d.picture("map").shape[1])

    def test_map_cell(self):
        self.falls("Map.cell", [0.05, 0.1, 0.5], lambda d: d.picture("map").size)

    def test_map_minCount(self):
        self.falls("Map.minCount", [1, 10, 100], lambda d: d.obstacle_cells())

    # [ipc]
    def test_ipc_memory(self):
        result = run("vdispd", "--sim", "--frames", 1, "--set", "ipc.memory=4")
        self.assert_refused(result, 78, "memory")
        self.assertEqual(run("vdispd", "--sim", "--frames", 1, "--set", "ipc.memory=256").returncode, 0)

    def test_ipc_group(self):
        self.assert_refused(run("vdispd", "--sim", "--frames", 1, "--set", "ipc.group=no-such-group"), 78, "no-such-group")
        with Running("vdispd", "--sim", "--set", "ipc.group=nogroup"):
            owner = lambda: subprocess.run(["stat", "-c", "%G", "/dev/shm/iceoryx_mgmt"], capture_output=True, text=True).stdout.strip()
            self.assertTrue(wait_until(lambda: owner() == "nogroup", 5), owner())

    # [sim]
    def test_sim_scene(self):
        # Little pitch: some beams hang above what a camera sees that looks down.
        def left(scene):
            return self.dump(f"sim.scene={scene}", "sim.pitch=0.05").picture("camera/left").astype(int)
        first = left("flat")
        for scene in ("drive", "obstacles", "empty", "wall", "crowded", "overhangs", "blank", "office", "garage", "rocks"):
            self.assertGreater(numpy.abs(first - left(scene)).mean(), 2, scene)

    # In a world a step is worth a second: ten of them are a way.
    WORLD = ("sim.scene=garage", "sim.seed=5", "sim.rate=2")

    def test_sim_drive(self):
        def travelled(drive, *sets):
            return float(self.way(f"sim.drive={drive}", *sets, frames=12)[0][-1]["travelled"])
        self.assertEqual(travelled("scene"), 0)
        self.assertGreater(travelled("expert"), 1)
        fast, slow = (travelled("command", "main.detectors=vdisparity", f"decide.speed={speed}") for speed in (0.5, 0.2))
        self.assertGreater(slow, 0.5)
        self.assertGreater(fast, 1.3 * slow)
        refused = ["main.detectors=none"], ["sim.scene=flat"]
        for sets, words in zip(refused, ("nobody makes", "drive = command")):
            sets = [word for item in (*self.WORLD, "sim.drive=command", *sets) for word in ("--set", item)]
            self.assert_refused(run("vdispd", "--sim", *sets), 78, words)

    def way(self, *sets, frames=40):
        """The robot's track and its world."""
        Parameters.runs += 1
        folder = self.folder / f"track{Parameters.runs}"
        arguments = [word for item in (*BASE, "main.detectors=none", *self.WORLD, *sets, f"sim.track={folder}") for word in ("--set", item)]
        result = run("vdispd", *arguments, "--frames", frames)
        self.assertEqual(result.returncode, 0, result.stderr)
        with open(folder / "track.csv") as track, open(folder / "world.csv") as world:
            return list(csv.DictReader(track)), [line.split(",")[0] for line in world][1:]

    def test_sim_exploration(self):
        def wilful(exploration):  # frames in which it turned though the way was free
            track, _ = self.way("sim.drive=expert", f"sim.exploration={exploration}")
            return sum(row["expert"] == "forward" and abs(float(row["turn_rate"])) > 0.15 for row in track)
        self.assertEqual(wilful(0), 0)
        self.assertGreater(wilful(1), 5)

    def test_sim_glass(self):
        for value, found in (("no", False), ("yes", True)):
            self.assertEqual("glass" in self.way(f"sim.glass={value}", frames=1)[1], found)

    def test_sim_track(self):
        track, world = self.way("sim.drive=expert", frames=12)
        self.assertEqual(len(track), 12)
        self.assertEqual([float(row["time_s"]) for row in track[:3]], [0, 0.5, 1])
        step = float(track[11]["x"]) - float(track[10]["x"]), float(track[11]["y"]) - float(track[10]["y"])
        self.assertAlmostEqual(float(numpy.hypot(*step)), float(track[11]["travelled"]) - float(track[10]["travelled"]), delta=0.01)
        self.assertGreater(world.count("wall"), 3)
        words = ("--set", "sim.scene=garage", "--set", "sim.track=/proc/nowhere")
        self.assert_refused(run("vdispd", "--sim", *words), 73, "/proc/nowhere")
        self.assert_refused(run("vdispd", "--sim", "--set", "sim.scene=flat", *words[2:]), 78, "track = /proc/nowhere")

    def test_sim_light(self):
        self.rises("sim.light", [0.2, 1, 3], lambda d: d.picture("camera/left").mean())

    def test_sim_shadow(self):
        # What lies in the shadow of the paper's five objects.
        self.falls("sim.shadow", [0, 0.4, 0.8], lambda d: numpy.percentile(d.picture("camera/left")[120:], 5), "sim.scene=obstacles", "sim.noise=0")

    def test_sim_seed(self):
        one, again, other = (self.dump(f"sim.seed={seed}").picture("camera/left") for seed in (5, 5, 6))
        numpy.testing.assert_array_equal(one, again)
        self.assertGreater(numpy.abs(one.astype(int) - other).mean(), 2)

    def test_sim_rate(self):
        self.falls("sim.rate", [5, 50], lambda d: d.json["timestamp_ns"], frames=2)

    def test_sim_width_and_height(self):
        self.assertEqual(self.dump("sim.width=400", "sim.height=200").picture("camera/left").shape, (200, 400))

    def test_sim_cameraHeight(self):
        self.rises("sim.cameraHeight", [0.6, 0.8, 1.0], lambda d: d.floor("height_m"), "sim.scene=empty")

    def test_sim_pitch(self):
        self.rises("sim.pitch", [0.2, 0.3, 0.4], lambda d: d.floor("pitch_rad"), "sim.scene=empty")

    def test_sim_roll(self):
        # With the right side low the camera's right is nearer to the ground: more disparity there.
        def lean(dumped):
            row = dumped.picture("truth/disparity")[180].astype(float)
            return row[240:280].mean() - row[40:80].mean()
        self.rises("sim.roll", [-0.2, 0, 0.2], lean, "sim.scene=empty")

    def test_sim_yaw(self):
        def objects(dumped):
            return numpy.mean([o["x"] for o in dumped.json["truth_scene"]["objects"]])
        self.rises("sim.yaw", [-0.2, 0, 0.2], objects, "sim.scene=obstacles")

    def test_sim_slope(self):
        # Rising ground hides the horizon: more of the picture is ground.
        self.rises("sim.slope", [-0.1, 0, 0.1], lambda d: (d.picture("truth/object") == 0).sum(), "sim.scene=empty")

    def test_sim_ground(self):
        # Kinds of cells that the truth has: 3 = the edge of a drop-off; the slope begins farther away on a ramp.
        def edges(ground):
            return (self.dump(f"sim.ground={ground}", "sim.scene=empty", "sim.slope=0.1").picture("truth/map_cells") == 3).sum()
        self.assertEqual([edges("slope"), edges("ramp"), edges("crest")], [0, 0, 0])
        self.assertGreater(edges("kerb"), 5)
        self.assertGreater(edges("ditch"), 10)
        scenes = [self.dump(f"sim.ground={ground}", "sim.slope=0.1").json["truth_scene"] for ground in ("slope", "ramp", "crest", "kerb")]
        self.assertLess(scenes[0]["foot_m"], scenes[1]["foot_m"])
        self.assertEqual([scene["crest_m"] > 0 for scene in scenes], [False, False, True, False])
        self.assertEqual([scene["drop"] is None for scene in scenes], [True, True, True, False])
        self.assert_refused(run("vdispd", "--sim", "--set", "sim.ground=ditch", "--set", "sim.scene=drive"), 78, "ground = ditch")

    def test_sim_roughness(self):
        # Bumps move the ground up and down in the picture: its disparities along a row are no longer equal.
        self.rises("sim.roughness", [0, 0.02, 0.05], lambda d: d.picture("truth/disparity")[180:230].std(axis=1).mean(), "sim.scene=empty")

    def test_sim_pitching(self):
        def swing(dumped):
            return dumped.json["truth_scene"]["pitch_rad"] - 0.2618
        self.rises("sim.pitching", [0, 0.05, 0.1], swing, "sim.pitchingRate=2", frames=4)

    def test_sim_pitchingRate(self):
        # A tenth of a second after the start: 36 and 72 degrees into the sine.
        for rate, part in ((1, 0.588), (2, 0.951)):
            scene = self.dump("sim.pitching=0.1", f"sim.pitchingRate={rate}", frames=4).json["truth_scene"]
            self.assertAlmostEqual((scene["pitch_rad"] - 0.2618) / 0.1, part, delta=0.002)

    def test_sim_event(self):
        def left(event):
            return self.dump(f"sim.event={event}").picture("camera/left").astype(float)
        usual = left("none")
        for event, least, most in (("cap", 0, 3), ("dark", 0, 8), ("bright", 250, 255), ("blank", 145, 155)):
            picture = left(event)
            self.assertTrue(least <= picture.mean() <= most, f"{event}: mean {picture.mean()}")
            self.assertLess(picture.std(), usual.std() / 3, event)

    def test_sim_eventFrame(self):
        def mean(first):
            return self.dump("sim.event=cap", f"sim.eventFrame={first}", frames=3).picture("camera/left").mean()
        self.assertLess(mean(1), 5)
        self.assertLess(mean(2), 5)
        self.assertGreater(mean(3), 50)

    def test_sim_noise(self):
        def difference(dumped):
            return numpy.abs(dumped.picture("camera/left").astype(float) - clean).mean()
        clean = self.dump("sim.noise=0").picture("camera/left").astype(float)
        self.rises("sim.noise", [0, 2, 10], difference)

    def test_sim_gain(self):
        self.rises("sim.gain", [0.8, 1, 1.2], lambda d: d.picture("camera/right").mean() / d.picture("camera/left").mean())

    def test_sim_distortion(self):
        def work(dumped):
            return numpy.abs(dumped.picture("camera/left").astype(float) - dumped.picture("left")).mean()
        self.rises("sim.distortion", [0, 0.1, 0.3], work)

    def test_sim_texture(self):
        self.rises("sim.texture", [0, 0.5, 1], lambda d: d.picture("camera/left")[150:].std(), "sim.noise=0", "sim.scene=empty")

    def test_sim_floor(self):
        def wrong(dumped):  # pixels that a matcher took for their neighbours
            found, true = (dumped.picture(stage).astype(int) for stage in ("disparity", "truth/disparity"))
            return int(((found > 0) & (true > 0) & (abs(found - true) > 24)).sum())
        gravel, tiles = (wrong(self.dump(f"sim.floor={value}", "sim.scene=empty", "image source.align=none")) for value in ("gravel", "tiles"))
        self.assertLess(10 * gravel, tiles)

    def test_sim_odometry(self):
        blind, told = (self.dump(f"sim.odometry={value}", "sim.scene=drive", frames=3) for value in ("no", "yes"))
        self.assertEqual(blind.json["stages"]["in/odometry"]["reason"], "no_odometry")
        self.assertTrue(told.valid("in/odometry"))
        self.assertNotEqual(told.json["odometry"]["x"], 0)

    def test_sim_imu(self):
        nods = "sim.pitching=0.08", "sim.pitchingRate=3"
        blind, told = (self.dump(f"sim.imu={value}", *nods, frames=4) for value in ("no", "yes"))
        self.assertEqual(blind.json["stages"]["in/imu"]["reason"], "no_imu")
        self.assertEqual(blind.floor("imu"), "none")
        self.assertEqual(told.floor("imu"), "used")
        self.assertAlmostEqual(told.json["imu"]["pitch"], told.json["truth_scene"]["pitch_rad"] - 0.2618, delta=0.001)

    def test_image_source_odometry(self):
        poses = self.folder / "poses.csv"
        poses.write_text("frame,x,y,yaw\n0,0,0,0\n1,0.5,0.25,0.1\n")
        told = self.files(*self.pairs(), f"image source.odometry={poses}", frames=2).json["odometry"]
        self.assertEqual((told["x"], told["y"], told["yaw"]), (0.5, 0.25, 0.1))
        self.assertFalse(self.files(*self.pairs(), f"image source.odometry={poses}", frames=3).valid("in/odometry"))
        poses.write_text("1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 2 0 1 0 0 0 0 1 3\n")
        told = self.files(*self.pairs(), f"image source.odometry={poses}", frames=2).json["odometry"]
        self.assertEqual((told["x"], told["y"]), (3, -2))

    # [census] and [snow]: the second detector with weights made by hand, for its settings.
    def snow(self, *sets, frames=1, base=BASE, **model):
        """Scores of the base scene by a model that is made for these settings of [census]."""
        given = dict(item.partition("census.")[2].split("=") for item in sets if item.startswith("census."))
        scale = int(given.get("scale", 1))
        words = {"width": 320 // scale, "height": 240 // scale, "disparities": given.get("width", 32), "near": 25}
        words |= {key: given[key] for key in ("block", "smooth", "confidence", "encoding") if key in given} | model
        path = self.folder / "model.snow"
        subprocess.run([BIN / "vdisp-make-model", path, *(f"{key}={value}" for key, value in words.items())], check=True)
        return self.dump("main.detectors=snow", "census.scale=1", f"snow.model={path}", *sets, frames=frames, base=base)

    def test_census_scale(self):
        for scale in (1, 2, 3):
            dumped = self.snow(f"census.scale={scale}")
            self.assertEqual(dumped.picture("smooth/left").shape, (240 // scale, 320 // scale))
            self.assertEqual(dumped.picture("census/left").shape, (240 // scale, 320 // scale))

    def test_census_smooth(self):
        def noise(word):
            return numpy.abs(numpy.diff(self.snow(f"census.smooth={word}").picture("smooth/left").astype(float))).mean()
        none, median, mean = (noise(word) for word in ("none", "median", "mean"))
        self.assertLess(median, none)
        self.assertLess(mean, none)
        self.assertNotEqual(mean, median)

    def refused(self, why, *sets):
        return self.snow(*sets).json["rejected"]["census_disparity"][why]

    def test_census_block(self):
        def scatter(block):  # of what is found, from row to row
            found = self.snow(f"census.block={block}", "census.confidence=0").picture("census_disparity").astype(int)
            return numpy.abs(numpy.diff(found[20:-20, 60:-20], axis=0)).mean()
        found = [scatter(block) for block in (3, 9, 17)]
        self.assertGreater(found[0], found[1])
        self.assertGreater(found[1], found[2])

    def test_census_width(self):
        found = [self.snow(f"census.width={width}").picture("depth_map").shape[0] for width in (16, 32, 64)]
        self.assertEqual(found, [16, 32, 64])
        self.assertLess(self.refused("outside", "census.width=16"), self.refused("outside", "census.width=64"))

    def test_census_confidence(self):
        found = [self.refused("low_texture", f"census.confidence={bits}") for bits in (0, 0.8, 2)]
        self.assertEqual(found[0], 0)
        self.assertLess(found[1], found[2])

    def test_census_encoding(self):
        pictures = {word: self.snow(f"census.encoding={word}").picture("features") for word in ("disparity-map", "depth-map", "contour", "contour-height")}
        self.assertEqual([p.shape for p in pictures.values()], [(60, 80), (60, 80), (1, 80), (2, 80)])
        self.assertLess(pictures["disparity-map"].max(), 32)
        self.assertGreater(pictures["depth-map"].max(), 32)
        numpy.testing.assert_array_equal(pictures["contour"][0], pictures["contour-height"][0])

    def test_snow_model(self):
        weak, strong = (self.snow(weight=weight).json["snow"] for weight in (1, 5))
        self.assertLess(weak["obstacle"], strong["obstacle"])
        for model, code, word in ((self.folder / "none", 66, "none"), (BIN / "vdispd", 78, "vdispd")):
            sets = [w for item in [*BASE, "main.detectors=snow", f"snow.model={model}"] for w in ("--set", item)]
            self.assert_refused(run("vdispd", *sets, "--frames", 1), code, word)
        sets = [w for item in [*BASE, "main.detectors=snow"] for w in ("--set", item)]
        self.assert_refused(run("vdispd", *sets, "--frames", 1), 78, "[snow] model", "vdisp-train")
        path = self.folder / "model.snow"
        sets = [w for item in [*BASE, "main.detectors=snow", "census.scale=1", "census.block=7", f"snow.model={path}"] for w in ("--set", item)]
        self.assert_refused(run("vdispd", *sets, "--frames", 1), 78, "model.snow", "block is 9 and not 7")

    def test_snow_obstacleSensitivity(self):
        for value, steering in ((-100, {"turn_left", "turn_right"}), (100, {"forward"})):
            self.assertIn(self.snow(f"snow.obstacleSensitivity={value}").json["decision"]["steering"], steering)
        told = self.snow("snow.obstacleSensitivity=model", sensitivity=0.125).json["snow"]
        self.assertEqual(told["obstacle_sensitivity"], 0.125)

    def test_snow_directionSensitivity(self):
        for value, steering in ((-100, "turn_right"), (100, "turn_left")):
            self.assertEqual(self.snow("snow.obstacleSensitivity=-100", f"snow.directionSensitivity={value}").json["decision"]["steering"], steering)

    def test_snow_clear(self):
        found = [self.snow("snow.obstacleSensitivity=20", f"snow.clear={clear}").json["decision"]["clearness"] for clear in (40, 60, 100)]
        self.assertGreater(found[0], found[1])
        self.assertGreater(found[1], found[2])
        self.assertGreater(found[2], 0)

    # [decide]
    AHEAD = ("sim.scene=obstacles", "decide.near=0.8", "decide.far=6", "decide.width=1.2")  # something stands ahead, beyond near

    def test_decide_speed(self):
        self.rises("decide.speed", [0.3, 0.6, 2], lambda d: d.json["drive_command"]["speed"], "sim.scene=empty")

    def test_decide_leastSpeed(self):
        self.rises("decide.leastSpeed", [0, 0.2, 0.4], lambda d: d.json["drive_command"]["speed"], *self.AHEAD)

    def test_decide_turnRate(self):
        self.rises("decide.turnRate", [0.3, 1, 2], lambda d: abs(d.json["drive_command"]["turn_rate"]), "sim.scene=obstacles", "decide.near=5.5",
                   "decide.far=6", "decide.width=1.2")

    def test_decide_width(self):
        self.falls("decide.width", [0.2, 3], lambda d: d.json["decision"]["clearness"], "sim.scene=obstacles", "decide.near=0.8", "decide.far=6", "decide.margin=0")

    def test_decide_margin(self):
        self.falls("decide.margin", [0, 1.4], lambda d: d.json["decision"]["clearness"], "sim.scene=obstacles", "decide.near=0.8", "decide.far=6", "decide.width=0.2")

    def test_decide_near(self):
        self.assertEqual(self.dump(*self.AHEAD).json["decision"]["steering"], "forward")
        self.assertNotEqual(self.dump(*self.AHEAD, "decide.near=5.5").json["decision"]["steering"], "forward")

    def test_decide_far(self):
        self.falls("decide.far", [2, 6, 20], lambda d: d.json["decision"]["clearness"], *self.AHEAD)

    def boxes_by_turns(self):
        """A box on the right, nothing, a box on the left; as the words that give these pairs."""
        random = numpy.random.default_rng(4)
        wall, box = (random.integers(60, 200, (240, 400), numpy.uint8) for _ in range(2))
        for side in ("left", "right"):
            (self.folder / side).mkdir()
        for i, at in enumerate((220, None, 80)):
            for side, shift in (("left", 0), ("right", 1)):
                picture = wall[:, 5 * shift:5 * shift + 320].copy()
                if at:
                    picture[60:200, at - 25 * shift:at - 25 * shift + 70] = box[60:200, :70]
                cv2.imwrite(str(self.folder / side / f"{i:06d}.png"), picture)
        return ["main.middleware=none", "main.debug=0", "image source.source=files", "image source.rate=10", *(
            f"image source.{side}={self.folder}/{side}/%06d.png" for side in ("left", "right"))]

    def steerings(self, files, *sets):
        dumped = self.snow(*sets, frames=3, base=files, near=40, sensitivity=0.05)
        return [self.frame(dumped.folder, i)["decision"]["steering"] for i in range(3)]

    def test_decide_hold(self):
        # By itself each is turned from to the other side.
        files = self.boxes_by_turns()
        for hold, steering in ((0, "turn_right"), (0.05, "turn_right"), (5, "turn_left")):
            self.assertEqual(self.steerings(files, f"decide.hold={hold}", "decide.clearEnough=0"), ["turn_left", "forward", steering], hold)

    def test_decide_clearEnough(self):
        files = self.boxes_by_turns()
        self.assertEqual(self.steerings(files, "decide.clearEnough=0", "snow.clear=100")[1], "forward")
        self.assertEqual(self.steerings(files, "decide.clearEnough=1", "snow.clear=100")[1], "turn_left", "free, and not clear")

    # [Memory]
    def test_memory_range(self):
        self.rises("Memory.range", [3, 6, 12], lambda d: d.picture("fused").shape[0])

    def test_memory_keep(self):
        # 14 and more: what was seen before, and not in this frame.
        self.rises("Memory.keep", [0.3, 60], lambda d: (d.picture("fused_reason") >= 14).sum(), "sim.scene=drive", "sim.odometry=yes", "sim.rate=5", frames=30)

    def test_memory_maxLag(self):
        def memory(lag):
            return self.accepted("0,0,0\n0,0,0\n", "control.maxAge=20", f"Memory.maxLag={lag}", "sim.width=320", "sim.height=240", pause=0.3,
                                 topics=("left", "memory"))["memory"]
        late = memory(0.05)
        self.assertEqual((late["state"], late["cause"]), ("frame_only", "late"))
        self.assertEqual(memory(2)["state"], "fused")

    # [control]
    def test_control_socket(self):
        place = self.folder / "door"
        with Running("vdispd", "--sim", "--set", f"control.socket={place}"):
            self.assertTrue(wait_until(lambda: run("vdisp-probe", "get", "thresh", "--control", place).returncode == 0))
            self.assertEqual(run("vdisp-probe", "get", "thresh").returncode, 69)

    def accepted(self, lines, *sets, pause, topics=("left", "in/odometry")):
        """What in/odometry, or another topic, says after poses were sent, 0.1 s from one to the next, and a pause."""
        Parameters.runs += 1
        folder = self.folder / f"run{Parameters.runs}"
        with Running("vdispd", "--sim", *[word for item in ("sim.width=160", "sim.height=120", "image source.ndisp=32", *sets) for word in ("--set", item)]):
            subprocess.run([BIN / "vdisp-probe", "send", "odometry", "--rate", "10", "--wait", "10"], input=lines, text=True, check=True, stdout=subprocess.DEVNULL)
            time.sleep(pause)
            self.assertEqual(run("vdisp-probe", "dump", folder, "--once", *topics).returncode, 0)
        return self.frame(folder, 0)

    def test_control_maxAge(self):
        self.assertEqual(self.accepted("0,0,0\n", "control.maxAge=0.2", pause=0.5)["stages"]["in/odometry"]["reason"], "no_odometry")
        self.assertTrue(self.accepted("0,0,0\n", "control.maxAge=20", pause=0.5)["stages"]["in/odometry"]["valid"])

    def test_control_maxSpeed(self):
        for speed, accepted in ((5, 1), (40, 2)):
            self.assertEqual(self.accepted("0,0,0\n1.5,0,0\n", f"control.maxSpeed={speed}", pause=0.3)["odometry"]["accepted"], accepted)

    def test_control_maxTurn(self):
        for turn, accepted in ((3, 1), (40, 2)):
            self.assertEqual(self.accepted("0,0,0\n0,0,1.5\n", f"control.maxTurn={turn}", pause=0.3)["odometry"]["accepted"], accepted)

    # recordings
    def record(self, *sets, frames=4):
        Parameters.runs += 1
        folder = self.folder / f"drive{Parameters.runs}"
        arguments = [word for item in [*BASE, *sets] for word in ("--set", item)]
        result = run("vdispd", *arguments, "--frames", frames, "--record", folder)
        self.assertEqual(result.returncode, 0, result.stderr)
        return folder

    def test_image_source_recording(self):
        drive = self.record("sim.seed=5")
        again = self.files(f"image source.recording={drive}", frames=4)
        live = self.dump("sim.seed=5", frames=4)
        numpy.testing.assert_array_equal(again.picture("disparity"), live.picture("disparity"))
        self.assertEqual(again.json["timestamp_ns"], live.json["timestamp_ns"])

    def flights(self, *sets, wait=1.2, asks=1):
        """The folders that the flight recorder wrote, oldest first, each when it was asked."""
        Parameters.runs += 1
        folder = self.folder / f"flight{Parameters.runs}"
        values = ("sim.width=160", "sim.height=120", "image source.ndisp=32", "sim.rate=30", "main.detectors=none", f"recorder.folder={folder}",
                  "recorder.free=0", "recorder.seconds=5", *sets)
        with Running("vdispd", "--sim", *[word for item in values for word in ("--set", item)]) as daemon:
            self.assertTrue(wait_until(lambda: "ready" in daemon.text()), daemon.text())
            time.sleep(wait)
            for _ in range(asks):
                run("vdisp-probe", "dump-flight")
        return sorted(folder.iterdir()) if folder.exists() else []

    def steps(self, *sets, **options):
        return len((self.flights(*sets, **options)[0] / "index.csv").read_text().splitlines()) - 1

    def test_recorder_seconds(self):
        self.assertEqual(self.flights("recorder.seconds=0"), [])
        self.assertLess(self.steps("recorder.seconds=0.3"), self.steps("recorder.seconds=1"))

    def test_recorder_memory(self):
        self.assertLess(self.steps("recorder.memory=1", wait=2.5), 30)  # 1 MiB holds 26 pairs of 160x120
        self.assertGreater(self.steps("recorder.memory=4", wait=2.5), 40)

    def test_recorder_folder(self):
        self.assertEqual(len(self.flights()), 1)
        self.assert_refused(run("vdispd", "--sim", "--set", "recorder.seconds=1"), 78, "without folder")

    def test_recorder_keep(self):
        self.assertEqual([len(self.flights(f"recorder.keep={keep}", asks=3, wait=0.3)) for keep in (1, 2, 10)], [1, 2, 3])

    def test_recorder_free(self):
        self.assertEqual(len(self.flights("recorder.free=1")), 1)
        self.assertEqual(self.flights("recorder.free=1048576"), [])

    def test_no_key_is_without_a_proof(self):
        section, missing = "", []
        proofs = {name for name in dir(self) if name.startswith("test_")}
        for line in run("vdispd", "--print-config").stdout.splitlines():
            if line.startswith("["):
                section = line.strip("[]").lower().replace(" ", "_")
            elif re.match(r"\w+ *=", line):
                key = re.match(r"\w+", line).group()
                if not any(name.startswith(f"test_{section}_") and re.search(rf"_{key}(_|$)", name) for name in proofs):
                    if not (section == "map" and key == "angRot"):
                        missing.append(f"[{section}] {key}")
        self.assertEqual(missing, [])


isolated_main(network=True)
