#!/usr/bin/python3
"""105: ground, the daemon alone: nothing stands on what is bare, whatever the camera and the ground do, and no ramp leads down a kerb. The seeds are
those with which it once was so.

SPDX-License-Identifier: Apache-2.0
"""
import json
import pathlib

import cv2
import numpy as np

from programs import ProgramTest, isolated_main, run

OBSTACLE = 65  # occupancy, percent


class Ground(ProgramTest):
    def dump(self, frames, **sim):
        """Runs a scene with [mounting] told; the folder of each frame."""
        folder = pathlib.Path(self.folder) / "-".join(f"{key}-{value}" for key, value in sim.items())
        words = {"main.middleware": "none", "image source.source": "sim", "sim.rate": 0, "sim.cameraHeight": 0.8,
                 "sim.pitch": 0.2618, "mounting.height": 0.8, "mounting.pitch": 0.2618, **{f"sim.{key}": value for key, value in sim.items()}}
        done = run("vdispd", "--frames", str(frames), "--dump", str(folder), *[w for k, v in words.items() for w in ("--set", f"{k}={v}")])
        self.assertEqual(done.returncode, 0, done.stderr)
        places = sorted(folder.glob("0*"))
        self.assertEqual(len(places), frames)
        return places

    def assert_bare(self, frames, **sim):
        for path in self.dump(frames, scene="empty", **sim):
            path /= "occupancy.png"
            cells = cv2.imread(str(path), cv2.IMREAD_UNCHANGED).astype(np.uint8).view(np.int8)
            self.assertGreater(int(((cells >= 0) & (cells < OBSTACLE)).sum()), 300, f"{path}: free cells")
            self.assertEqual(int((cells >= OBSTACLE).sum()), 0, f"{path}: obstacle cells")

    def test_a_camera_that_pitches_by_two_degrees_from_frame_to_frame_sees_no_obstacles(self):
        for seed in (301, 330):
            self.assert_bare(18, seed=seed, pitching=0.08727, pitchingRate=2)

    def test_ground_of_bumps_has_no_obstacles_where_the_plane_leans_with_them(self):
        self.assert_bare(18, seed=422, roughness=0.05)

    def test_a_kerb_that_leads_along_the_way_is_no_ramp_to_the_ground_below(self):
        for seed in (502, 510):
            for frame in self.dump(4, scene="flat", ground="kerb", seed=seed):
                floor = json.loads((frame / "frame.json").read_text())["floor"]
                self.assertAlmostEqual(floor["pitch_rad"], 0.2618, delta=0.0175)
                self.assertAlmostEqual(floor["height_m"], 0.8, delta=0.024)
                profile = floor["profile"]
                lowest = min(place["height_m"] for place in profile if place["ahead_m"] < 3.5)
                self.assertGreater(lowest, -0.1, f"{frame}: the step is 0.32 m")


if __name__ == "__main__":
    isolated_main()
