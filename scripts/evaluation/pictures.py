# pictures.py: what the matchers found, side by side, for the eye.
# SPDX-License-Identifier: Apache-2.0
import cv2
import numpy as np


def coloured(values, most):
    """0 is black."""
    scaled = np.clip(values / most * 255, 0, 255).astype(np.uint8)
    picture = cv2.applyColorMap(scaled, cv2.COLORMAP_TURBO)
    picture[values <= 0] = 0
    return picture


def labelled(picture, text):
    cv2.putText(picture, text, (8, 20), cv2.FONT_HERSHEY_SIMPLEX, 0.6, (0, 0, 0), 3, cv2.LINE_AA)
    cv2.putText(picture, text, (8, 20), cv2.FONT_HERSHEY_SIMPLEX, 0.6, (255, 255, 255), 1, cv2.LINE_AA)
    return picture


def write(folder, views):
    """SET.png: the first pair. First row: left view and truth; then a row for each matcher: what it found, and where that and the
    truth have a value the error, blue 0 to red 4 px."""
    folder.mkdir(parents=True, exist_ok=True)
    pair = views.pairs[0]
    known = np.where(pair.region, pair.truth, 0)
    left = cv2.cvtColor(views.left[0], cv2.COLOR_GRAY2BGR)
    rows = [np.hstack([labelled(left, views.name), labelled(coloured(known, views.ndisp), "truth")])]
    for matcher, disparities in views.results.items():
        found = disparities[0] / 16.0
        error = np.where((found > 0) & pair.region, np.maximum(np.abs(found - pair.truth), 0.02), 0)
        rows.append(np.hstack([labelled(coloured(found, views.ndisp), matcher), labelled(coloured(error, 4), "error, red: 4 px or more")]))
    cv2.imwrite(str(folder / f"{views.name}.png"), np.vstack(rows))
