#!/usr/bin/python3
"""105: bare ground, the daemon alone: nothing stands there, whatever the camera and the ground do. The seeds are those with which it once did.

SPDX-License-Identifier: Apache-2.0
"""
import pathlib

import cv2
import numpy as np

from programs import ProgramTest, isolated_main, run

OBSTACLE = 65  # occupancy, percent


class Ground(ProgramTest):
    def assert_bare(self, frames, **sim):
        """Runs scene `empty` with [mounting] told; a map of each frame, none with an obstacle."""
        folder = pathlib.Path(self.folder) / "-".join(f"{key}-{value}" for key, value in sim.items())
        words = {"main.middleware": "none", "image source.source": "sim", "sim.rate": 0, "sim.scene": "empty", "sim.cameraHeight": 0.8,
                 "sim.pitch": 0.2618, "mounting.height": 0.8, "mounting.pitch": 0.2618, **{f"sim.{key}": value for key, value in sim.items()}}
        done = run("vdispd", "--frames", str(frames), "--dump", str(folder), *[w for k, v in words.items() for w in ("--set", f"{k}={v}")])
        self.assertEqual(done.returncode, 0, done.stderr)
        maps = sorted(folder.glob("0*/occupancy.png"))
        self.assertEqual(len(maps), frames)
        for path in maps:
            cells = cv2.imread(str(path), cv2.IMREAD_UNCHANGED).astype(np.uint8).view(np.int8)
            self.assertGreater(int(((cells >= 0) & (cells < OBSTACLE)).sum()), 300, f"{path}: free cells")
            self.assertEqual(int((cells >= OBSTACLE).sum()), 0, f"{path}: obstacle cells")

    def test_a_camera_that_pitches_by_two_degrees_from_frame_to_frame_sees_no_obstacles(self):
        for seed in (301, 330):
            self.assert_bare(18, seed=seed, pitching=0.08727, pitchingRate=2)

    def test_ground_of_bumps_has_no_obstacles_where_the_plane_leans_with_them(self):
        self.assert_bare(18, seed=422, roughness=0.05)


if __name__ == "__main__":
    isolated_main()
