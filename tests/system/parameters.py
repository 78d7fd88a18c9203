"""parameters.py: what the tests of the table of parameters share: a run of the daemon, and what it did.

SPDX-License-Identifier: Apache-2.0
"""
import subprocess
import time

import cv2
import numpy

from programs import BIN, ProgramTest, Running, run

# A small scene with everything in it: ground, obstacles near and far, noise.
BASE = ["main.middleware=none", "main.debug=0", "image source.source=sim", "sim.scene=flat", "sim.seed=3", "sim.width=320",
        "sim.height=240", "sim.rate=0", "image source.ndisp=32"]


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


class ParameterTest(ProgramTest):
    runs = 0

    def dump(self, *sets, frames=1, base=BASE):
        ParameterTest.runs += 1
        folder = self.folder / f"run{ParameterTest.runs}"
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

    def files(self, *sets, frames=1):
        return self.dump(*sets, frames=frames, base=["main.middleware=none", "main.debug=0", "image source.ndisp=32",
                                                     "image source.source=files"])

    def pairs(self, width=320, height=240):
        folder = self.write_pairs(3, width, height)
        return [f"image source.left={folder}/left/%06d.png", f"image source.right={folder}/right/%06d.png"]

    def snow(self, *sets, frames=1, base=BASE, **model):
        """Scores of the base scene by a model that is made for these settings of [census]."""
        given = dict(item.partition("census.")[2].split("=") for item in sets if item.startswith("census."))
        scale = int(given.get("scale", 1))
        words = {"width": 320 // scale, "height": 240 // scale, "disparities": given.get("width", 32), "near": 25}
        words |= {key: given[key] for key in ("block", "smooth", "confidence", "encoding") if key in given} | model
        path = self.folder / "model.snow"
        subprocess.run([BIN / "vdisp-make-model", path, *(f"{key}={value}" for key, value in words.items())], check=True)
        return self.dump("main.detectors=snow", "census.scale=1", f"snow.model={path}", *sets, frames=frames, base=base)

    def accepted(self, lines, *sets, pause, topics=("left", "in/odometry")):
        """What in/odometry, or another topic, says after poses were sent, 0.1 s from one to the next, and a pause."""
        ParameterTest.runs += 1
        folder = self.folder / f"run{ParameterTest.runs}"
        with Running("vdispd", "--sim", *[word for item in ("sim.width=160", "sim.height=120", "image source.ndisp=32", *sets) for word in ("--set", item)]):
            subprocess.run([BIN / "vdisp-probe", "send", "odometry", "--rate", "10", "--wait", "10"], input=lines, text=True, check=True, stdout=subprocess.DEVNULL)
            time.sleep(pause)
            self.assertEqual(run("vdisp-probe", "dump", folder, "--once", *topics).returncode, 0)
        return self.frame(folder, 0)
