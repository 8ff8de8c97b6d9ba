"""What the tests share: a camera, and what it sees."""

import highwall as hw
import numpy as np
import pytest

SHIFT, DEPTH = 4, 2.0  # [px] a frame, [m]


def moving_wall(camera, frames):
    """Stamp, colour and depth of a wall of blocks that passes to the left."""
    random = np.random.default_rng(1)
    blocks = random.integers(0, 256, (camera.height // 8, camera.width // 8 + frames), dtype=np.uint8)
    wall = np.repeat(np.repeat(blocks, 8, axis=0), 8, axis=1)
    for i in range(frames):
        view = wall[:, i * SHIFT : i * SHIFT + camera.width]
        yield i * 33_000_000, np.dstack([view] * 3), np.full(view.shape, DEPTH, np.float32)


@pytest.fixture(name="sensor")
def make_sensor():
    camera = hw.PinholeCamera(width=320, height=240, fx=262.5, fy=262.5, cx=159.5, cy=119.5)
    return hw.RgbdSensor(camera=camera)
