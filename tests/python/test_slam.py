"""Images go in as arrays; poses, maps and errors come out."""

import gc

import highwall as hw
import numpy as np
import pytest
from conftest import DEPTH, SHIFT, moving_wall


def test_a_sensor_has_a_pattern_of_depth(sensor):
    np.testing.assert_array_equal(sensor.depth_pattern, np.zeros(20))
    sensor.depth_pattern = np.linspace(-0.01, 0.01, 20)
    np.testing.assert_array_equal(sensor.depth_pattern, np.linspace(-0.01, 0.01, 20))


def test_slam_follows_a_camera_and_reports_it(sensor):
    slam = hw.SlamSystem(sensor, hw.SlamOptions(deterministic=True))
    keyframes, frames = {}, []
    slam.set_callbacks(
        on_keyframe=lambda id, T_WC, stamp, bgr, depth: keyframes.update({id: (T_WC, bgr, depth)}),
        on_frame=frames.append,
    )
    images = list(moving_wall(sensor.camera, 10))
    slam.set_backlog(1)
    for stamp, bgr, depth in images:
        assert slam.track(stamp, bgr, depth).state == hw.TrackingState.TRACKING
    slam.finish()
    # Synchronously no adjustment is running when a keyframe is due.
    assert slam.postponed() == {"keyframes": 0, "loop_searches": len(keyframes) - len(keyframes) // 3}
    np.testing.assert_array_equal(slam.sensor().depth_pattern, np.zeros(20))
    assert 0 < slam.refined_frames() < len(images)  # keyframes are not among them
    assert [frame.stamp for frame in frames] == [stamp for stamp, _, _ in images]
    np.testing.assert_array_equal(frames[0].covariance, np.zeros((6, 6)))  # where the world begins
    for frame in frames[1:]:
        assert 0 < np.linalg.eigvalsh(frame.covariance_in_keyframe)[0]
        assert np.trace(frame.covariance) >= np.trace(frame.covariance_in_keyframe)
    _, bgr, depth = keyframes[0]
    np.testing.assert_array_equal(bgr, images[0][1])
    np.testing.assert_array_equal(depth, images[0][2])
    trajectory = slam.trajectory()
    assert trajectory.poses.shape == (10, 7)
    # World: x along the optical axis, so that a camera that moves to its right goes along -y.
    way = trajectory.poses[-1, :3] - trajectory.poses[0, :3]
    np.testing.assert_allclose(way, [0, -9 * SHIFT * DEPTH / sensor.camera.fx, 0], atol=2e-3)
    assert slam.map_points().shape[1] == 3 and len(slam.map_points()) > 100
    assert slam.map_lines().shape[1] == 6


def test_frames_have_velocities_in_the_end(sensor):
    slam = hw.SlamSystem(sensor, hw.SlamOptions(deterministic=True))
    images = list(moving_wall(sensor.camera, 40))
    for image in images:
        slam.track(*image)
    assert slam.velocities() == []
    slam.finish()
    velocities = slam.velocities()
    assert [velocity.stamp for velocity in velocities] == [image[0] for image in images]
    seconds = (images[1][0] - images[0][0]) * 1e-9
    middle = velocities[20]
    speed = SHIFT * DEPTH / sensor.camera.fx / seconds
    # Poses err by a twentieth of a step.
    np.testing.assert_allclose(middle.v_WC, [0, -speed, 0], atol=0.05 * speed)
    np.testing.assert_allclose(middle.omega_C, np.zeros(3), atol=0.01)
    assert 0 < np.linalg.eigvalsh(middle.covariance)[0]


def test_what_a_callback_raises_reaches_the_caller(sensor):
    slam = hw.SlamSystem(sensor)

    def refuse(frame):
        raise RuntimeError("enough")

    slam.set_callbacks(on_frame=refuse)
    with pytest.raises(RuntimeError, match="enough"):
        slam.track(*next(moving_wall(sensor.camera, 1)))


def test_positions_of_the_user_place_their_frame(sensor):
    slam = hw.SlamSystem(sensor, hw.SlamOptions(deterministic=True))
    gps = slam.add_reference_frame()
    T_GW = hw.Pose.from_tangent([100, 200, 30], [0, 0, 1.5])
    assert slam.T_FW(gps) is None
    for i, image in enumerate(moving_wall(sensor.camera, 25)):
        p_W = [0, -i * SHIFT * DEPTH / sensor.camera.fx, 0]
        p_G = (T_GW * hw.Pose(p_W, [0, 0, 0, 1])).p
        factor = hw.PositionFactor(p_G, np.zeros(3), np.eye(3) / 0.005)
        slam.add_factor([image[0]], factor, gps, loss=hw.HuberLoss(3.0), source="gps")
        assert slam.factor_counts.waiting == 1
        slam.track(*image)
    slam.finish()
    assert slam.factor_counts.attached == 25 and slam.factor_counts.refused == 0
    slam.add_factor([2**60], factor, gps)
    by_source = slam.factor_counts_by_source
    assert by_source["gps"].attached == 25 and by_source["gps"].waiting == 0
    assert by_source[""].attached == 0 and by_source[""].waiting == 1
    # The wall is square to the way: the camera, and with it W, may be off by what a pixel says.
    np.testing.assert_allclose(slam.T_FW(gps).p, T_GW.p, atol=5e-3)
    with pytest.raises(hw.InvalidArgument, match="2 blocks of 7"):
        slam.add_factor([0], hw.PosePrior(hw.Pose(), np.eye(6)), gps)
    with pytest.raises(hw.InvalidArgument, match="no such frame"):
        slam.T_FW(7)


class Height(hw.Factor):
    """The height [m] of the body over where it began."""

    def __init__(self, height):
        super().__init__(1, [hw.Pose])
        self.height, self.calls = height, 0

    def evaluate(self, T_WB):
        self.calls += 1
        return [(T_WB.p[2] - self.height) / 0.01], [np.array([[0, 0, 100.0, 0, 0, 0]])]


@pytest.mark.parametrize("deterministic", [True, False])
def test_a_factor_in_python_takes_part(sensor, tmp_path, deterministic):
    slam = hw.SlamSystem(sensor, hw.SlamOptions(deterministic=deterministic))
    heights = []
    for image in moving_wall(sensor.camera, 25):
        heights.append(Height(0.0))
        slam.add_factor([image[0]], heights[-1])
        slam.track(*image)
    slam.finish()
    assert all(height.calls > 0 for height in heights)
    assert slam.save_map(tmp_path / "map.hwmap", sensor.camera) == 25, "code that no file holds"


def test_a_system_that_goes_while_its_threads_evaluate_in_python_does_not_hang(sensor):
    slam = hw.SlamSystem(sensor)
    for image in moving_wall(sensor.camera, 25):
        slam.add_factor([image[0]], Height(0.0))
        slam.track(*image)
    del slam


def test_an_exception_of_a_factor_is_reported_and_slam_continues(sensor, monkeypatch):
    reported = []
    monkeypatch.setattr("sys.unraisablehook", lambda error: reported.append(str(error.exc_value)))

    class Broken(Height):
        def evaluate(self, T_WB):
            raise KeyError("no height")

    slam = hw.SlamSystem(sensor)
    for image in moving_wall(sensor.camera, 25):
        slam.add_factor([image[0]], Broken(0.0))
        assert slam.track(*image).state == hw.TrackingState.TRACKING
    slam.finish()
    assert "no height" in reported[0]


class Corners(hw.PointExtractor):
    """Where blocks meet, and what surrounds them: 64 pixels of every other row and column."""

    def __init__(self, **kind):
        super().__init__(**{"name": "corners", "columns": 64, "descriptor": hw.DescriptorType.FLOAT, "levels": 1,
                            "scale_factor": 2.0, **kind})
        self.images = 0

    def extract(self, gray):
        self.images += 1
        image = gray.astype(np.float32)
        strength = np.abs(image[:-1, :-1] - image[:-1, 1:] - image[1:, :-1] + image[1:, 1:])
        strength[:8], strength[-8:], strength[:, :8], strength[:, -8:] = 0, 0, 0, 0
        v, u = np.unravel_index(np.argsort(strength, axis=None)[-500:], strength.shape)
        patches = [image[y - 7 : y + 9 : 2, x - 7 : x + 9 : 2].ravel() for x, y in zip(u, v)]
        keypoints = np.column_stack([u + 0.5, v + 0.5, 0 * u, -1 + 0 * u, strength[v, u]])
        return keypoints, np.array(patches)


@pytest.mark.parametrize("deterministic", [True, False])
def test_an_extractor_in_python_is_tracked(sensor, tmp_path, deterministic):
    corners = Corners()
    slam = hw.SlamSystem(sensor, hw.SlamOptions(deterministic=deterministic, lines=False), points=corners)
    for image in moving_wall(sensor.camera, 10):
        frame = slam.track(*image)
        assert frame.state == hw.TrackingState.TRACKING and frame.points == 500
    slam.finish()
    assert corners.images == 10 and corners.name == "corners"
    poses = slam.trajectory().poses
    # Corners lie where they are to the pixel's fraction.
    np.testing.assert_allclose(poses[-1, :3] - poses[0, :3], [0, -9 * SHIFT * DEPTH / sensor.camera.fx, 0], atol=1e-3)
    slam.save_map(tmp_path / "map.hwmap", sensor.camera)
    assert b"corners" in (tmp_path / "map.hwmap").read_bytes()


def test_an_extractor_lives_as_long_as_its_system(sensor):
    slam = hw.SlamSystem(sensor, points=Corners())
    gc.collect()
    assert slam.track(*next(moving_wall(sensor.camera, 1))).points == 500


def test_what_an_extractor_raises_or_gives_wrongly_comes_out_of_track(sensor):
    image = next(moving_wall(sensor.camera, 1))

    def track(extract):
        kind = type("Wrong", (Corners,), {"extract": extract})
        hw.SlamSystem(sensor, points=kind()).track(*image)

    def raises(self, gray):
        raise RuntimeError("no battery")

    with pytest.raises(RuntimeError, match="no battery"):
        track(raises)
    descriptors = np.zeros((2, 64), np.float32)
    for found, says in [
        (np.zeros((2, 5)), r"returns \(keypoints, descriptors\)"),
        ((np.zeros((2, 4)), descriptors), "N x 5"),
        ((np.full((2, 5), np.nan), descriptors), "keypoint 0 has no octave"),
        ((np.zeros((2, 5)), descriptors.astype(float)), "uint8 or float32"),
        ((np.zeros((2, 5)), descriptors[:, :7]), "7 columns, not 64"),
        ((np.zeros((2, 5)), descriptors[:1]), "2 keypoints have 1 rows"),
        ((np.full((2, 5), 1000.0), descriptors), "keypoint 0 is at"),
    ]:
        with pytest.raises(hw.InvalidArgument, match="points by corners: .*" + says):
            track(lambda self, gray: found)
    with pytest.raises(hw.InvalidArgument, match="extract"):
        hw.SlamSystem(sensor, points=hw.PointExtractor("none", 32)).track(*image)
    with pytest.raises(hw.InvalidArgument, match="columns must be"):
        Corners(columns=0)
    with pytest.raises(hw.InvalidArgument, match="PointExtractor"):
        hw.SlamSystem(sensor, points="corners")
    blind = type("Blind", (Corners,), {"extract": lambda self, gray: ([], [])})
    assert hw.SlamSystem(sensor, points=blind()).track(*image).points == 0


def test_row_times_and_noise_are_estimated_online(sensor):
    assert hw.SlamSystem(sensor).sensor().noise.point_px.shape == (16,)
    assert hw.SlamSystem(sensor).sensor().noise.refined_px.shape == (16,)
    assert hw.SlamSystem(sensor).sensor().noise.low_contrast_px.shape == (16,)
    left = hw.ReadoutDirection.LEFT
    sensor.timing = hw.FrameTiming(colour_readout=0.02, depth_delay=-0.01, direction=left)
    slam = hw.SlamSystem(sensor, hw.SlamOptions(deterministic=True))
    before = slam.sensor().noise
    for image in moving_wall(sensor.camera, 25):
        slam.track(*image)
    slam.finish()
    timing = slam.sensor().timing
    # A wall that passes at one speed reveals little of the read-out: it stays near its prior.
    assert abs(timing.value.colour_readout - 0.02) <= 3 * timing.sigma.colour_readout > 0
    assert timing.value.direction == left
    noise = slam.sensor().noise
    # Depth is without error here: better than was known, down to what views share (docs/noise.md).
    assert noise.point_depth[2] < 0.9 * before.point_depth[2]
    assert noise.point_depth.shape == noise.edge_depth.shape == noise.line_px.shape == noise.line_depth.shape == (4,)


def test_images_of_another_shape_are_refused(sensor):
    slam = hw.SlamSystem(sensor)
    with pytest.raises(hw.InvalidArgument, match="height x width x 3"):
        slam.track(0, np.zeros((240, 320), np.uint8), np.zeros((240, 320), np.float32))
    with pytest.raises(hw.InvalidArgument):
        slam.track(0, np.zeros((10, 10, 3), np.uint8), np.zeros((10, 10), np.float32))


def test_errors_of_a_trajectory_are_what_was_put_in(tmp_path):
    stamps = np.arange(50) * 100_000_000
    t = stamps * 1e-9
    poses = np.column_stack([t, np.sin(t), 0.1 * t**2, 0 * t, 0 * t, 0 * t, 1 + 0 * t])
    truth = hw.Trajectory(stamps, poses)
    moved = poses.copy()
    moved[::2, 2] += 0.02
    moved[1::2, 2] -= 0.02
    error = hw.absolute_pose_error(
        truth, hw.Trajectory(stamps, moved), alignment=hw.TrajectoryAlignment.NONE
    )
    assert error.statistics.rmse == pytest.approx(0.02, abs=1e-12)
    np.testing.assert_allclose(error.errors, 0.02, atol=1e-12)
    relative = hw.relative_pose_error(truth, hw.Trajectory(stamps, moved))
    assert relative.statistics.median == pytest.approx(0.04, abs=1e-12)
    truth.write_tum(tmp_path / "truth.txt")
    again = hw.Trajectory.read_tum(tmp_path / "truth.txt")
    np.testing.assert_array_equal(again.stamps, stamps)
    np.testing.assert_allclose(again.interpolate(150_000_000).p[0], 0.15, atol=1e-9)
    with pytest.raises(hw.IoError, match="missing.txt"):
        hw.Trajectory.read_tum(tmp_path / "missing.txt")


def test_a_scale_is_found_by_alignment():
    random = np.random.default_rng(3)
    b = random.normal(size=(20, 3))
    T = hw.Pose.from_tangent([1, 2, 3], [0.1, -0.2, 0.3])
    a = np.array([(T * hw.Pose(1.25 * p, [0, 0, 0, 1])).p for p in b])
    found = hw.align_umeyama(a, b, with_scale=True)
    assert found.scale == pytest.approx(1.25, abs=1e-12)
    np.testing.assert_allclose(found.T_AB.p, T.p, atol=1e-12)
    np.testing.assert_allclose((found * hw.Pose(b[4], [0, 0, 0, 1])).p, a[4], atol=1e-12)
    assert hw.align_umeyama(a, b).scale == 1.0
    assert hw.align_umeyama(a[:2], b[:2]) is None
    with pytest.raises(hw.InvalidArgument):
        hw.align_umeyama(a, b[:3])
    stamps = np.arange(20) * 100_000_000
    turns = np.tile([0, 0, 0, 1.0], (20, 1))
    truth, small = hw.Trajectory(stamps, np.hstack([b, turns])), hw.Trajectory(stamps, np.hstack([b / 2, turns]))
    for alignment in (hw.TrajectoryAlignment.SIM3, hw.TrajectoryAlignment.SCALE):
        error = hw.absolute_pose_error(truth, small, alignment=alignment)
        assert error.scale == pytest.approx(2.0) and error.statistics.rmse < 1e-12


def test_octree_and_cloud_are_arrays(tmp_path, sensor):
    camera = sensor.camera
    _, bgr, depth = next(moving_wall(camera, 1))
    octree = hw.OctomapBuilder(hw.OctomapBuilderOptions(resolution=0.1))
    octree.insert(depth, camera, hw.Pose())
    centres, edges, log_odds, occupied = octree.leaves()
    assert centres.shape == (len(edges), 3) and occupied.dtype == bool
    # The wall is where it was measured, to a voxel.
    np.testing.assert_allclose(centres[occupied, 2], DEPTH, atol=0.1)
    np.testing.assert_array_equal(occupied, log_odds >= 0)
    hit, distance, known = octree.cast_ray([0.01, 0.01, 0.5], [0, 0, 1], 3.0)
    assert known and abs(hit[2] - DEPTH) <= 0.1
    assert octree.is_occupied([5, 5, 5]) is None
    octree.write(tmp_path / "map.ot")
    assert len(hw.OctomapBuilder.read(tmp_path / "map.ot").leaves()[0]) == len(centres)
    cloud = hw.make_keyframe_cloud(depth, bgr, camera)
    assert cloud.points.dtype == np.float32 and cloud.rgb.dtype == np.uint8
    np.testing.assert_allclose(cloud.points[:, 2], DEPTH, atol=1e-6)
    cloud.write_ply(tmp_path / "cloud.ply")
    np.testing.assert_array_equal(hw.PointCloud.read_ply(tmp_path / "cloud.ply").points, cloud.points)


def test_the_dense_map_follows_its_keyframes(sensor):
    _, bgr, depth = next(moving_wall(sensor.camera, 1))
    mapper = hw.DenseMapper(sensor.camera, sensor.depth_noise, background=False)
    mapper.add_keyframe(0, 0, bgr, depth, hw.Pose())
    mapper.set_poses({0: hw.Pose.from_tangent([0, 0, 1], np.zeros(3))})
    (dense,) = mapper.finish()
    np.testing.assert_allclose(dense.cloud.points[:, 2], DEPTH + 1, atol=1e-5)


def test_options_that_do_not_exist_or_fit_are_refused():
    with pytest.raises(AttributeError, match="iterations"):
        hw.SolveOptions(iterations=3)
    with pytest.raises(hw.InvalidArgument, match="max_iterations"):
        hw.SolveOptions(max_iterations=-1)


def test_images_of_another_type_are_refused_with_what_to_do(sensor):
    slam = hw.SlamSystem(sensor)
    mapper = hw.DenseMapper(sensor.camera)
    octree = hw.OctomapBuilder()
    _, bgr, depth = next(moving_wall(sensor.camera, 1))
    for wrong in (bgr / 255, (bgr / 255).astype(np.float32), bgr.astype(np.int64), bgr.astype(np.uint16),
                  bgr.astype(np.int8), bgr > 100, bgr.tolist(), bgr.astype(object)):
        for use in (
            lambda: slam.track(0, wrong, depth),
            lambda: mapper.add_keyframe(0, 0, wrong, depth, hw.Pose()),
            lambda: hw.make_keyframe_cloud(depth, wrong, sensor.camera),
        ):
            with pytest.raises(TypeError, match="a colour image is an array of uint8, not of .*astype"):
                use()
    for wrong in (depth.astype(np.int64), depth.astype(np.uint8), depth.astype(np.int32), depth.astype(np.int16),
                  depth > 1, depth.astype(complex), depth.astype(object)):
        for use in (
            lambda: slam.track(0, bgr, wrong),
            lambda: mapper.add_keyframe(0, 0, bgr, wrong, hw.Pose()),
            lambda: hw.make_keyframe_cloud(wrong, bgr, sensor.camera),
            lambda: octree.insert(wrong, sensor.camera, hw.Pose()),
        ):
            with pytest.raises(TypeError, match="a depth image is an array of floats or uint16, .*depth_factor"):
                use()
    assert mapper.finish() == [] and len(octree.leaves()[0]) == 0
    with pytest.raises(TypeError, match="rgb is an array of uint8"):
        hw.PointCloud(np.zeros((2, 3)), np.full((2, 3), 0.5))
    assert slam.track(0, bgr, depth).state == hw.TrackingState.TRACKING, "what was refused left no trace"


@pytest.mark.parametrize("type", [np.float16, np.float32, np.float64, ">f4", np.uint16])
def test_depth_of_floats_and_uint16_is_in_metres(sensor, type):
    _, bgr, depth = next(moving_wall(sensor.camera, 1))
    assert hw.SlamSystem(sensor).track(0, bgr, depth.astype(type)).state == hw.TrackingState.TRACKING
    cloud = hw.make_keyframe_cloud(depth.astype(type), bgr, sensor.camera)
    np.testing.assert_allclose(cloud.points[:, 2], DEPTH, atol=1e-6)


def test_images_that_are_not_contiguous_are_read_as_they_are(sensor):
    _, bgr, depth = next(moving_wall(sensor.camera, 1))
    wide = np.zeros((240, 640, 3), np.uint8)
    wide[:, ::2] = bgr
    slam, keyframes = hw.SlamSystem(sensor), []
    slam.set_callbacks(on_keyframe=lambda id, T_WC, stamp, bgr, depth: keyframes.append((bgr, depth)))
    slam.track(0, wide[:, ::2], np.asfortranarray(depth))
    np.testing.assert_array_equal(keyframes[0][0], bgr)
    np.testing.assert_array_equal(keyframes[0][1], depth)


@pytest.mark.parametrize("type", [np.uint16, np.float32])
@pytest.mark.parametrize("near", [0, 1, 1000])
def test_millimetres_are_refused_even_with_some_readings_below_100(sensor, type, near):
    _, bgr, depth = next(moving_wall(sensor.camera, 1))
    millimetres = (1000 * depth).astype(type)
    millimetres.flat[:near] = 50
    with pytest.raises(hw.InvalidArgument, match="must be in metres, but .* of it lies beyond 100 m"):
        hw.SlamSystem(sensor).track(0, bgr, millimetres)
