#!/usr/bin/python3
"""113: the parameters of the simulator.

SPDX-License-Identifier: Apache-2.0
"""
import csv

import numpy

from parameters import BASE, ParameterTest
from programs import isolated_main, run


class Simulator(ParameterTest):
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
        ParameterTest.runs += 1
        folder = self.folder / f"track{ParameterTest.runs}"
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


isolated_main()
