"""small_worlds.py: labelled recordings of rooms with boxes on a textured floor, ray by ray: truth for training that is no code of ours.

SPDX-License-Identifier: Apache-2.0
"""
import json
import pathlib

import cv2
import numpy

F, BASELINE, HEIGHT, PITCH = 240.0, 0.1, 0.8, 0.3  # px, m, m, rad
NEAR, HALF_WIDTH = 1.3, 0.4                        # m: what is nearer on the way has to be turned from
NAMES = ("forward", "left", "right")


def texture(seed, a, b):
    """Brightness of a surface with coordinates a and b (m): squares of 2 and 5 cm, each of its own."""
    total = numpy.zeros(a.shape)
    for cell, weight in ((0.02, 0.5), (0.05, 0.5)):
        x, y = numpy.floor(a / cell).astype(numpy.int64), numpy.floor(b / cell).astype(numpy.int64)
        mixed = (x * 73856093 ^ y * 19349663 ^ (seed + 1) * 83492791) & 0x7FFFFFFF
        mixed = (mixed * 1103515245 + 12345) & 0x7FFFFFFF
        total += weight * ((mixed >> 8) % 256)
    return total


class World:
    """Boxes as (x, z, half width, height), seen from a camera at (0, HEIGHT, 0), looking along z and down by PITCH."""

    def __init__(self, chance):
        self.seed = int(chance.integers(1 << 20))
        self.boxes = [(chance.uniform(-2.5, 2.5), chance.uniform(2.5, 4.5), chance.uniform(0.2, 0.5), chance.uniform(0.4, 1.2))
                      for _ in range(chance.integers(1, 4))]
        self.label = "forward"
        if chance.random() < 0.5:
            x = chance.uniform(0.08, 0.35) * chance.choice((-1, 1))
            self.boxes.append((x, chance.uniform(0.6, NEAR - 0.1), chance.uniform(0.2, 0.35), chance.uniform(0.5, 1.2)))
            self.label = "left" if x > 0 else "right"

    def view(self, x_camera, width, height, scale=1.0):
        u, v = numpy.meshgrid(numpy.arange(width), numpy.arange(height))
        across = (u - width / 2) / (F * scale)
        down = (v - height / 2) / (F * scale)
        ray_y = down * numpy.cos(PITCH) + numpy.sin(PITCH)    # down
        ray_z = numpy.cos(PITCH) - down * numpy.sin(PITCH)
        far = numpy.full(across.shape, 6.0) / numpy.maximum(ray_z, 1e-3)  # the wall behind
        image = texture(self.seed + 1, x_camera + across * far, ray_y * far)
        with numpy.errstate(divide="ignore"):
            floor = numpy.where(ray_y > 1e-6, HEIGHT / ray_y, 1e9)
        near = floor < far
        image[near] = texture(self.seed + 2, (x_camera + across * floor)[near], (ray_z * floor)[near])
        depth = numpy.minimum(floor, far)
        for number, (x, z, half, high) in enumerate(self.boxes):
            reach = z / numpy.maximum(ray_z, 1e-3)
            at_x, at_y = x_camera + across * reach - x, ray_y * reach
            hit = (reach < depth) & (abs(at_x) < half) & (at_y > HEIGHT - high) & (at_y <= HEIGHT)
            image[hit] = texture(self.seed + 3 + number, at_x[hit], at_y[hit])
            depth[hit] = reach[hit]
        return image

    def pair(self, chance, width=320, height=240):
        gain = chance.uniform(0.8, 1.0, 2)
        views = (self.view(x, width, height, width / 320) for x in (0.0, BASELINE))
        return [numpy.clip(g * view + chance.normal(0, 2, view.shape), 0, 255).astype(numpy.uint8) for g, view in zip(gain, views)]


def write_recording(folder, labelled_pairs, width=320, height=240, seed=0):
    """`labelled_pairs`: (label, left, right), ten in a second."""
    folder = pathlib.Path(folder)
    for side in ("left", "right"):
        (folder / side).mkdir(parents=True)
    lines = ["timestamp_ns,label,left,right,speed,turn_rate"]
    for number, (label, *views) in enumerate(labelled_pairs):
        name = f"{number * 100000000}_{label}.png"
        for side, view in zip(("left", "right"), views):
            cv2.imwrite(str(folder / side / name), view)
        lines.append(f"{number * 100000000},{label},left/{name},right/{name},0.5,0")
    (folder / "index.csv").write_text("\n".join(lines) + "\n")
    (folder / "recording.json").write_text(json.dumps({
        "format": "vdisp recording", "version": 1, "program": "small_worlds.py", "source": "drawn", "world": "boxes", "seed": seed,
        "epoch": seed, "width": width, "height": height, "synthetic": True}))
    return folder


def drive(folder, seed, pairs=24, labels=NAMES, width=320, height=240):
    """A recording of so many pairs, each of a world of its own; `labels`: those that occur."""
    chance = numpy.random.default_rng(seed)

    def drawn():
        made = 0
        while made < pairs:
            world = World(chance)
            if world.label in labels:
                made += 1
                yield (world.label, *world.pair(chance, width, height))
    return write_recording(folder, drawn(), width, height, seed)
