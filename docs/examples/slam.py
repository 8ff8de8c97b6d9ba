# %% [markdown]
# # SLAM, its error, a cloud and an octree
#
# A script in cells: run it as it is, or cell by cell in an editor; `jupytext --to ipynb slam.py` makes a notebook of it.
#
#     python3 slam.py [FOLDER IN THE LAYOUT OF TUM RGB-D] [--camera tum1]
#
# Without a folder it makes a short recording of a wall for itself.

# %%
import argparse

import highwall as hw
import numpy as np

arguments = argparse.ArgumentParser(description="SLAM, its error, a cloud and an octree")
arguments.add_argument("folder", nargs="?", help="recording in the layout of TUM RGB-D")
arguments.add_argument("--camera", default="tum1", help="tum1, tum2 or tum3")
arguments.add_argument("--out", help="write cloud.ply and map.bt into this folder")
arguments = arguments.parse_args()

# %% [markdown]
# ## A recording
# Blocks of random grey 2 m away, seen by a camera that moves to the right by 4 pixels, that is 15 mm, a frame.


# %%
def moving_wall(camera, frames=20, shift=4, depth=2.0):
    random = np.random.default_rng(1)
    rows, columns = camera.height // 8 + 1, (camera.width + frames * shift) // 8 + 1
    grey = random.integers(0, 256, (rows, columns), dtype=np.uint8)
    wall = np.repeat(np.repeat(grey, 8, axis=0), 8, axis=1)
    for i in range(frames):
        view = wall[: camera.height, i * shift : i * shift + camera.width]
        bgr = np.repeat(view[:, :, np.newaxis], 3, axis=2)
        yield i * 33_000_000, bgr, np.full(view.shape, depth, np.float32)


def recording(folder, sensor):
    dataset = hw.open_dataset(folder, sensor)
    for image in (dataset.load(i) for i in range(len(dataset))):
        if image:
            yield image.stamp, image.bgr, image.depth


sensor = hw.RgbdSensor.preset(arguments.camera) if arguments.folder else hw.RgbdSensor()
frames = recording(arguments.folder, sensor) if arguments.folder else moving_wall(sensor.camera)

# %% [markdown]
# ## SLAM
# The dense map follows the system: keyframes without dynamic objects, one map for each submap.

# %%
slam = hw.SlamSystem(sensor, hw.SlamOptions(deterministic=True))
dense = hw.DenseMapper.following(slam, background=False)
for stamp, bgr, depth in frames:
    frame = slam.track(stamp, bgr, depth)
    if frame.T_WC is None:
        print(hw.format_stamp(stamp), "lost:", frame.reason)
slam.finish()
trajectory = slam.trajectory()
print(len(trajectory), "frames with a pose,", len(slam.map_points()), "points,",
      len(slam.map_lines()), "lines")

# %% [markdown]
# ## Its error
# Against the reference, or for the wall against what is known: it moved along one line, in equal steps.

# %%
if arguments.folder:
    error = hw.absolute_pose_error(hw.open_dataset(arguments.folder).groundtruth, trajectory)
    print("APE RMSE", error.statistics.rmse, "m")
else:
    way = np.linalg.norm(trajectory.poses[-1, :3] - trajectory.poses[0, :3])
    print("way", way, "m; true", 19 * 4 * 2.0 / sensor.camera.fx, "m")

# %% [markdown]
# ## Cloud and octree

# %%
for i, dense_map in enumerate(dense.finish()):
    centres, edges, log_odds, occupied = dense_map.octree.leaves()
    print(len(dense_map.cloud), "points;", np.count_nonzero(occupied), "occupied leaves of the octree")
    if arguments.out:
        number = f"_{i + 1}" if i > 0 else ""  # the first is that of most frames
        dense_map.cloud.write_ply(f"{arguments.out}/cloud{number}.ply")
        dense_map.octree.write_binary(f"{arguments.out}/map{number}.bt")
