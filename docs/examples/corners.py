"""SLAM with points and descriptors of its own."""

import highwall as hw
import numpy as np


class Corners(hw.PointExtractor):
    """Where brightness changes both ways, with the 64 pixels around."""

    def __init__(self):
        super().__init__("corners", 64, descriptor=hw.DescriptorType.FLOAT, levels=1, scale_factor=2.0)

    def extract(self, gray):
        image = gray.astype(np.float32)
        strength = np.abs(image[:-1, :-1] - image[:-1, 1:] - image[1:, :-1] + image[1:, 1:])
        strength[:8], strength[-8:], strength[:, :8], strength[:, -8:] = 0, 0, 0, 0  # no room for what is around
        v, u = np.unravel_index(np.argsort(strength, axis=None)[-500:], strength.shape)
        descriptors = [image[y - 7 : y + 9 : 2, x - 7 : x + 9 : 2].ravel() for x, y in zip(u, v)]
        keypoints = np.column_stack([u + 0.5, v + 0.5, 0 * u, -1 + 0 * u, strength[v, u]])
        return keypoints, np.array(descriptors)


slam = hw.SlamSystem(hw.RgbdSensor.preset("tum1"), points=Corners())
