#!/usr/bin/python3
"""112: the parameters of cameras: two GigE cameras that are programs, with pictures that are known.

SPDX-License-Identifier: Apache-2.0
"""

import cv2
import numpy

import gige
from parameters import ParameterTest
from programs import isolated_main


class Cameras(ParameterTest):
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


isolated_main(network=True)
