# map_pictures.py: left view, true cells and what each method found, side by side.
# SPDX-License-Identifier: Apache-2.0
import cv2
import numpy as np

import evaluation.geometry as geometry

HEIGHT = 320  # of a grid, pixels
RIGHT, WRONG, MISSED, UNJUDGED, OBSERVED = (0, 220, 0), (0, 0, 255), (255, 96, 0), (0, 160, 160), (64, 64, 64)


def enlarged(picture, text):
    scale = HEIGHT / picture.shape[0]
    large = cv2.resize(picture, (round(picture.shape[1] * scale), HEIGHT), interpolation=cv2.INTER_NEAREST)
    return cv2.copyMakeBorder(titled(large, text), 0, 2, 0, 2, cv2.BORDER_CONSTANT, value=(255, 255, 255))


def titled(picture, text):
    """A line above it, in as many rows as it has commas."""
    strip = np.zeros((44, picture.shape[1], 3), np.uint8)
    for i, part in enumerate(text.split(", ")):
        cv2.putText(strip, part, (4, 16 + 20 * i), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (255, 255, 255), 1, cv2.LINE_AA)
    return np.vstack([strip, picture])


def judged(found, to_find, observed, right):
    """Green: right within a cell. Red: wrong. Blue: missed. Ochre: found where the truth has not looked. Grey: observed."""
    picture = np.zeros(found.shape + (3,), np.uint8)
    picture[observed] = OBSERVED
    picture[to_find & ~geometry.wider(found)] = MISSED
    near = geometry.wider(right)
    picture[found & near], picture[found & ~near & observed], picture[found & ~near & ~observed] = RIGHT, WRONG, UNJUDGED
    return picture


def picture(look):
    to_find, observed, right = look["truth"]
    true = np.zeros(to_find.shape + (3,), np.uint8)
    true[observed], true[right], true[to_find] = OBSERVED, (160, 160, 160), (255, 255, 255)
    left = cv2.cvtColor(look["left"], cv2.COLOR_GRAY2BGR)
    parts = [enlarged(left, "left"), enlarged(true, "truth, white: to be found")]
    parts += [enlarged(judged(found, *look["truth"]), method) for method, found in look["grids"].items()]
    return np.hstack(parts)


def write(folder, name, look):
    folder.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(folder / f"peers-{name}.png"), picture(look))
