#!/usr/bin/python3
"""111: the parameters of pictures, floor and map.

SPDX-License-Identifier: Apache-2.0
"""
import pathlib
import re

import cv2
import numpy

from parameters import ParameterTest
from programs import isolated_main, run

# Boxes without texture, in the camera's full size.
BLANK = ["sim.scene=blank", "sim.seed=1", "sim.width=640", "sim.height=480", "image source.ndisp=48"]


class Images(ParameterTest):
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

    def test_image_source_odometry(self):
        poses = self.folder / "poses.csv"
        poses.write_text("frame,x,y,yaw\n0,0,0,0\n1,0.5,0.25,0.1\n")
        told = self.files(*self.pairs(), f"image source.odometry={poses}", frames=2).json["odometry"]
        self.assertEqual((told["x"], told["y"], told["yaw"]), (0.5, 0.25, 0.1))
        self.assertFalse(self.files(*self.pairs(), f"image source.odometry={poses}", frames=3).valid("in/odometry"))
        poses.write_text("1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 2 0 1 0 0 0 0 1 3\n")
        told = self.files(*self.pairs(), f"image source.odometry={poses}", frames=2).json["odometry"]
        self.assertEqual((told["x"], told["y"]), (3, -2))


isolated_main()
