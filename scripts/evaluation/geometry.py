# geometry.py: projection, grid and plane fit of the evaluation's own: nothing here comes from the daemon.
# SPDX-License-Identifier: Apache-2.0
import cv2
import numpy as np


class Grid:
    """The obstacle map's geometry: row 0 farthest, the camera below the last row in the middle, half-open cells."""

    def __init__(self, reach=5.0, width=5.1, cell=0.1):
        self.cell = cell
        self.rows, self.columns = round(reach / cell), round(width / cell)

    def cells(self, x, z):
        """Rows and columns of points (m right, m ahead); what lies outside is left out."""
        row = self.rows - 1 - np.floor(z / self.cell).astype(int)
        column = np.floor(x / self.cell + self.columns / 2).astype(int)
        inside = (row >= 0) & (row < self.rows) & (column >= 0) & (column < self.columns)
        return row[inside], column[inside]

    def mask(self, x, z):
        cells = np.zeros((self.rows, self.columns), bool)
        cells[self.cells(np.ravel(x), np.ravel(z))] = True
        return cells

    def counts(self, x, z):
        cells = np.zeros((self.rows, self.columns), int)
        np.add.at(cells, self.cells(np.ravel(x), np.ravel(z)), 1)
        return cells


def wider(mask, cells=1):
    """The mask and all within so many cells of it."""
    size = 2 * cells + 1
    return cv2.dilate(mask.astype(np.uint8), np.ones((size, size), np.uint8)) > 0


def distance_to(mask, cell):
    """Of each cell's centre to the nearest one in the mask, m; inf where the mask is empty."""
    if not mask.any():
        return np.full(mask.shape, np.inf)
    return cell * cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)


def camera_points(camera, depth):
    """Points of the camera frame (x right, y down, z along the view) for an image of depths."""
    v, u = np.mgrid[0 : depth.shape[0], 0 : depth.shape[1]]
    return (u - camera["cx"]) * depth / camera["f"], (v - camera["cy"]) * depth / camera["f"], depth


def level(points, pitch, roll=0.0):
    """Camera frame to the horizontal frame h: roll undone first, then pitch (positive: looks down, right side low)."""
    x, y, z = points
    x, y = x * np.cos(roll) - y * np.sin(roll), x * np.sin(roll) + y * np.cos(roll)
    return x, y * np.cos(pitch) + z * np.sin(pitch), z * np.cos(pitch) - y * np.sin(pitch)


def unlevel(points, pitch, roll=0.0):
    """Horizontal frame h to the camera frame."""
    x, y, z = points
    y, z = y * np.cos(pitch) - z * np.sin(pitch), y * np.sin(pitch) + z * np.cos(pitch)
    return x * np.cos(roll) + y * np.sin(roll), -x * np.sin(roll) + y * np.cos(roll), z


def fit_plane(points, reach, heights, tilt, seed=1, tries=2000):
    """Robust ground plane of camera-frame points (n, 3): unit normal pointing down, distance of the camera from it.

    RANSAC over planes whose distance lies within `heights` and that tilt less than `tilt` rad, then least squares on what lies
    within `reach`, as long as that keeps to the same limits."""
    random = np.random.default_rng(seed)
    sample = points[random.integers(0, len(points), min(len(points), 20000))]
    best, best_count = None, 0
    for _ in range(tries):
        a, b, c = sample[random.integers(0, len(sample), 3)]
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal)
        if length < 1e-6:
            continue
        normal = normal / length if normal[1] > 0 else -normal / length
        distance = normal @ a
        if normal[1] < np.cos(tilt) or not heights[0] < distance < heights[1]:
            continue
        count = np.count_nonzero(np.abs(sample @ normal - distance) < reach)
        if count > best_count:
            best, best_count = (normal, distance), count
    normal, distance = best
    for _ in range(5):
        near = sample[np.abs(sample @ normal - distance) < reach]
        middle = near.mean(axis=0)
        better = np.linalg.svd(near - middle, full_matrices=False)[2][2]
        better = better if better[1] > 0 else -better
        if better[1] < np.cos(tilt) or not heights[0] < better @ middle < heights[1]:
            break
        normal, distance = better, better @ middle
    return normal, distance


def pose_of_plane(normal):
    """Pitch and roll of a camera whose downward direction is `normal`."""
    return np.arcsin(normal[2]), np.arctan2(normal[0], normal[1])


def matchable(ndisp, corrsize, shape):
    """Pixels that a search over ndisp disparities with this window can match: True inside."""
    half, mask = corrsize // 2, np.zeros(shape, bool)
    mask[half : shape[0] - half, half + ndisp - 1 : shape[1] - half] = True
    return mask
