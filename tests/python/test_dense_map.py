"""A dense map that follows a system: without dynamic objects, each world by itself."""

import gc
import os
import subprocess
import weakref

import highwall as hw
import numpy as np
import pytest
from conftest import DEPTH, SHIFT, moving_wall


def wall_of(seed, camera, frames):
    """As moving_wall, of other blocks."""
    random = np.random.default_rng(seed)
    blocks = random.integers(0, 256, (camera.height // 8, camera.width // 8 + frames), dtype=np.uint8)
    wall = np.repeat(np.repeat(blocks, 8, axis=0), 8, axis=1)
    for i in range(frames):
        yield np.dstack([wall[:, i * SHIFT : i * SHIFT + camera.width]] * 3)


def test_it_is_the_map_of_the_keyframes_where_nothing_moves(sensor):
    slam = hw.SlamSystem(sensor, hw.SlamOptions(deterministic=True))
    dense = hw.DenseMapper.following(slam, voxel_size=0.02, resolution=0.1, background=False)
    for image in moving_wall(sensor.camera, 20):
        slam.track(*image)
    slam.finish()
    (found,) = dense.finish()
    # The wall is square to x of W, and as long as it was seen.
    np.testing.assert_allclose(found.cloud.points[:, 0], DEPTH, atol=0.01)
    width = (sensor.camera.width + 19 * SHIFT) * DEPTH / sensor.camera.fx
    assert np.ptp(found.cloud.points[:, 1]) == pytest.approx(width, rel=0.1)
    assert found.octree.is_occupied([DEPTH + 0.01, 0.01, 0.01])


def test_each_world_has_a_map_of_its_own_that_of_most_frames_first(sensor):
    slam = hw.SlamSystem(sensor, hw.SlamOptions(deterministic=True))
    dense = hw.DenseMapper.following(slam, voxel_size=0.05, resolution=0.1, background=False)
    stamps = iter(range(0, 10**12, 33_000_000))
    shape = (sensor.camera.height, sensor.camera.width)

    def track(images, depth):
        for bgr in images:
            slam.track(next(stamps), bgr, np.full(shape, depth, np.float32))

    track(wall_of(1, sensor.camera, 45), DEPTH)
    track([np.zeros((*shape, 3), np.uint8)] * 20, 0.0)  # dark, for longer than a submap waits
    track(wall_of(7, sensor.camera, 60), 3.0)
    slam.finish()
    maps = dense.finish()
    assert [round(float(np.median(found.cloud.points[:, 0])), 2) for found in maps] == [3.0, DEPTH]
    for found, depth in zip(maps, [3.0, DEPTH]):
        np.testing.assert_allclose(found.cloud.points[:, 0], depth, atol=0.02)


def with_a_passer_by(camera, frames):
    """A wall that stands, and a board at half its distance that crosses it."""
    for i, (stamp, bgr, depth) in enumerate(moving_wall(camera, frames)):
        random = np.random.default_rng(3)
        board = np.repeat(np.repeat(random.integers(0, 256, (20, 10), dtype=np.uint8), 8, axis=0), 8, axis=1)
        left = 6 * i
        bgr, depth = bgr.copy(), depth.copy()
        view = board[:, : max(0, camera.width - left)]
        bgr[40:200, left : left + 80] = np.dstack([view] * 3)
        depth[40:200, left : left + 80] = DEPTH / 2
        yield stamp, bgr, depth


def near(found):
    """Points of the board."""
    return np.count_nonzero(np.abs(found.cloud.points[:, 0] - DEPTH / 2) < 0.1)


def test_dynamic_objects_are_left_out(sensor):
    slam = hw.SlamSystem(sensor, hw.SlamOptions(deterministic=True))
    dense = hw.DenseMapper.following(slam, background=False)
    everything = hw.SlamSystem(sensor, hw.SlamOptions(deterministic=True, moving_objects=False))
    all_of_it = hw.DenseMapper.following(everything, background=False)
    for image in with_a_passer_by(sensor.camera, 40):
        slam.track(*image)
        everything.track(*image)
    slam.finish(), everything.finish()
    (still,), (moved,) = dense.finish(), all_of_it.finish()
    assert near(moved) > 0
    # But for the keyframes in which it had hardly begun to move.
    assert near(still) < 0.5 * near(moved)


@pytest.mark.skipif("HIGHWALL" not in os.environ, reason="the program is not built")
def test_it_is_the_map_that_the_program_makes(tmp_path):
    # Somebody walks through; rows of colour are taken one after another, and depth comes late.
    room, run = tmp_path / "room", tmp_path / "run"
    simulate = "--duration 5 --scale 0.5 --imu off --moving --readout 0.025 --depth-delay 0.01"
    for arguments in (
        ["simulate", "room", "--out", room, *simulate.split()],
        ["slam", "--dataset", room, "--out", run, "--deterministic"],
    ):
        subprocess.run([os.environ["HIGHWALL"], *arguments], check=True, capture_output=True)
    sensor = hw.read_sensor(room / "calibration.yaml").sensor
    slam = hw.SlamSystem(sensor, hw.SlamOptions(deterministic=True))
    dense = hw.DenseMapper.following(slam, background=False)
    frames = hw.open_dataset(room, sensor)
    for image in (frames.load(i) for i in range(len(frames))):
        slam.track(image.stamp, image.bgr, image.depth)
    slam.finish()
    (found,) = dense.finish()
    found.cloud.write_ply(tmp_path / "cloud.ply")
    found.octree.write_binary(tmp_path / "map.bt")
    assert (tmp_path / "cloud.ply").read_bytes() == (run / "cloud.ply").read_bytes()
    assert (tmp_path / "map.bt").read_bytes() == (run / "map.bt").read_bytes()


def test_it_follows_from_the_first_frame_or_not_at_all(sensor):
    slam = hw.SlamSystem(sensor)
    slam.track(*next(moving_wall(sensor.camera, 1)))
    with pytest.raises(hw.InvalidArgument, match="before track"):
        hw.DenseMapper.following(slam)
    with pytest.raises((TypeError, RuntimeError)):
        hw.DenseMapper.following(sensor)


def test_the_callbacks_of_the_user_are_called_as_well_and_may_raise(sensor):
    slam, keyframes = hw.SlamSystem(sensor, hw.SlamOptions(deterministic=True)), []
    dense = hw.DenseMapper.following(slam, background=False)

    def on_keyframe(id, *others):
        keyframes.append(id)
        raise ValueError("not this one")

    slam.set_callbacks(on_keyframe=on_keyframe)
    for image in moving_wall(sensor.camera, 20):
        try:
            slam.track(*image)
        except ValueError:
            pass
    slam.finish()
    (found,) = dense.finish()
    assert keyframes and len(found.cloud) > 1000


def test_a_mapper_that_is_gone_is_followed_no_more_and_a_finished_one_stays(sensor):
    slam = hw.SlamSystem(sensor)
    gone, dense = hw.DenseMapper.following(slam), hw.DenseMapper.following(slam)
    images = list(moving_wall(sensor.camera, 20))
    for image in images[:10]:
        slam.track(*image)
    del gone
    (found,) = dense.finish()
    for image in images[10:]:
        slam.track(*image)
    slam.finish()
    assert len(found.cloud) > 0 and len(slam.trajectory()) == 20


def test_a_mapper_keeps_its_system_and_a_cycle_of_both_is_freed(sensor):
    image = next(moving_wall(sensor.camera, 1))
    slam = hw.SlamSystem(sensor)
    dense = hw.DenseMapper.following(slam)
    slam.track(*image)
    del slam
    gc.collect()
    assert len(dense.finish()) == 1

    def make():
        slam = hw.SlamSystem(sensor)
        dense = hw.DenseMapper.following(slam)
        slam.set_callbacks(on_frame=lambda frame: dense)
        slam.track(*image)
        return weakref.ref(slam), weakref.ref(dense)

    alive = make()
    gc.collect()
    assert alive[0]() is None and alive[1]() is None


def test_a_callback_that_finishes_the_map_is_an_error_not_a_wait(sensor):
    slam = hw.SlamSystem(sensor)
    dense = hw.DenseMapper.following(slam)
    slam.set_callbacks(on_frame=lambda frame: dense.finish())
    with pytest.raises(RuntimeError, match="must not call it in turn"):
        slam.track(*next(moving_wall(sensor.camera, 1)))
