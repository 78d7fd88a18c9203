# peers.py: OpenCV's matchers with the settings that ours are compared at.
# SPDX-License-Identifier: Apache-2.0
import cv2
import numpy as np


def block_matcher(ndisp, own_speckle=False):
    """StereoBM, window 11, x-Sobel cap 31, texture 10, uniqueness 10, disp12MaxDiff 1, then speckle 100 px / 1 px by filterSpeckles.

    With `own_speckle` the filter is StereoBM's own with speckleRange 1, which is 1/16 px (StereoSGBM's is in pixels): it takes away
    most of what is not fronto-parallel."""
    matcher = cv2.StereoBM_create(ndisp, 11)
    matcher.setPreFilterType(cv2.StereoBM_PREFILTER_XSOBEL)
    matcher.setPreFilterCap(31)
    matcher.setTextureThreshold(10)
    matcher.setUniquenessRatio(10)
    matcher.setDisp12MaxDiff(1)
    if own_speckle:
        matcher.setSpeckleWindowSize(100)
        matcher.setSpeckleRange(1)

    def match(left, right):
        disparity = matcher.compute(left, right)
        if not own_speckle:
            cv2.filterSpeckles(disparity, -16, 100, 16)
        return disparity

    return match


def semi_global(ndisp, mode):
    """StereoSGBM, block 5, P1 200, P2 800, cap 63, uniqueness 10, disp12MaxDiff 1, speckle 100 px / 1 px."""
    return cv2.StereoSGBM_create(0, ndisp, 5, 200, 800, 1, 63, 10, 100, 1, mode).compute


PEERS = {
    "StereoBM": block_matcher,
    "StereoBM, own speckle 1/16 px": lambda ndisp: block_matcher(ndisp, own_speckle=True),
    "StereoSGBM 3WAY": lambda ndisp: semi_global(ndisp, cv2.STEREO_SGBM_MODE_SGBM_3WAY),
    "StereoSGBM HH": lambda ndisp: semi_global(ndisp, cv2.STEREO_SGBM_MODE_HH),
}


def match(name, left, right, ndisp):
    """Disparity in 1/16 px as a dump has it: 0 is none."""
    return np.maximum(PEERS[name](ndisp)(left, right), 0).astype(np.uint16)
