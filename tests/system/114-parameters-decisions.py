#!/usr/bin/python3
"""114: the parameters of the second detector, of decisions and of the memory.

SPDX-License-Identifier: Apache-2.0
"""
import cv2
import numpy

from parameters import BASE, ParameterTest
from programs import BIN, isolated_main, run


class Decisions(ParameterTest):
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


isolated_main()
