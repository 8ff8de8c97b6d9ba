"""Factors of the library answer in Python as they do in C++: residuals, and Jacobians that are right."""

import highwall as hw
import numpy as np
import pytest

CAMERA = hw.PinholeCamera()
PROJECTION = hw.RgbdProjection(CAMERA, hw.Pose.from_tangent([0.1, 0, 0.02], [0.1, 0.2, -0.1]))
T_1 = hw.Pose.from_tangent([0.2, -0.1, 0.3], [0.1, -0.2, 0.3])
T_2 = hw.Pose.from_tangent([0.5, 0.1, -0.2], [-0.3, 0.1, 0.2])
POINT = np.array([0.4, -0.3, 3.0])
SEGMENT = hw.Segment3([-0.5, 0.2, 2.5], [0.6, -0.3, 3.2])
LINE = hw.OrthonormalLine(hw.PluckerLine.from_points(SEGMENT.p, SEGMENT.q))
SMALL = hw.Pose.from_tangent([0.1, 0, 0.02], [0.1, 0.2, -0.1])
V = np.array([0.3, -0.2, 0.1])


def preintegration(n=21):
    stamps = np.arange(n) * 5_000_000
    t = stamps[:, np.newaxis] * 1e-9
    gyroscope = np.hstack([0.1 + 0 * t, 0.2 * np.sin(9 * t), -0.1 + t])
    accelerometer = np.hstack([0.3 + t, 0 * t, 9.81 + np.cos(5 * t)])
    return hw.ImuPreintegration(stamps, gyroscope, accelerometer)


def factors():
    s3, e3 = np.array([200.0, 150, 12]), np.array([400.0, 300, 10])
    bias, W6 = np.full(6, 0.01), np.diag([3.0, 4, 5, 20, 30, 40])
    rotation = np.array([0.1, 0.2, -0.1])
    yield hw.PosePrior(T_2, W6), (T_1,)
    yield hw.DirectionPrior(hw.UnitDirection(), 0.1), (hw.UnitDirection([0.1, 0.2, -1]),)
    yield hw.GravityPrior(0.1), (SMALL,)
    yield hw.PositionFactor(POINT, V, np.diag([1.0, 2, 3])), (T_1, T_2)
    yield hw.VectorPrior1([0.1], [[2.0]]), (0.3,)
    yield hw.VectorPrior2([1, 2], np.eye(2)), (np.zeros(2),)
    yield hw.VectorPrior3(POINT, np.diag([1.0, 2, 3])), (V,)
    yield hw.VectorPrior6(bias, np.eye(6)), (2 * bias,)
    yield hw.RelativePose(SMALL, W6), (T_1, T_2)
    yield hw.PointInFrame([0.1, 0.2, 2], np.eye(3)), (T_1, POINT)
    yield hw.PointReprojection([300, 200], np.eye(2), PROJECTION), (T_1, POINT)
    yield hw.PointReprojectionRgbd([300, 200, 14], np.eye(3), PROJECTION), (T_1, POINT)
    of_camera = hw.PointReprojectionRgbd([300, 200, 14], np.eye(3), hw.RgbdProjection(CAMERA))
    yield hw.ExtrinsicFactor(of_camera), (T_1, POINT, SMALL)
    of_body = hw.PointReprojectionRgbd([300, 200, 14], np.eye(3), PROJECTION)
    yield hw.TimeOffsetFactor(of_body, V, rotation), (T_1, POINT, 0.01)
    yield hw.LineReprojection(s3[:2], e3[:2], 1.0, PROJECTION), (T_1, SEGMENT)
    yield hw.LineReprojectionRgbd(s3, e3, PROJECTION), (T_1, SEGMENT)
    yield hw.OrthonormalLineReprojection(s3[:2], e3[:2], 1.0, PROJECTION), (T_1, LINE)
    yield hw.OrthonormalLineReprojectionRgbd(s3, e3, PROJECTION), (T_1, LINE)
    yield hw.CameraPose(T_2, W6, SMALL, rotation), (T_1, V, 0.01)
    yield hw.ExtrinsicCameraPose(T_2, W6, rotation), (T_1, V, 0.01, SMALL, 1.05)
    yield hw.ScaledMotion(SMALL, W6), (T_1, T_2, 1.05)
    yield hw.WhiteAcceleration(0.5, 0.5, 2.0), (T_1, bias, T_2, 2 * bias)
    yield hw.PointToPlane([0, 0, 1], [0, 0, 2], POINT, 0.1), (T_1, T_2)
    yield hw.ImuFactor(preintegration(), [0, 0, -9.81]), (T_1, V, bias, T_2, -V, bias)
    yield hw.ImuGravityFactor(preintegration()), (T_1, V, bias, T_2, -V, bias, hw.UnitDirection())
    yield hw.ZeroVelocity(0.02), (V,)


@pytest.mark.parametrize("factor, values", factors(), ids=lambda x: type(x).__name__)
def test_jacobians_are_those_of_central_differences(factor, values):
    # Whitened IMU rows reach 1e5: the rounding of a difference over 1e-6 is that large.
    check = hw.check_jacobians(factor, *values, relative=1e-5)
    assert check, check.message
    residuals, jacobians = factor.evaluate(*values)
    assert residuals.shape == (factor.num_residuals,)
    assert len(jacobians) == len(values)
    for value, jacobian in zip(values, jacobians):
        tangent = {hw.Pose: 6, hw.OrthonormalLine: 4, hw.Segment3: 6, hw.UnitDirection: 2}
        assert jacobian.shape == (factor.num_residuals, tangent.get(type(value), np.size(value)))


def test_every_factor_of_the_module_is_checked():
    checked = {type(factor) for factor, _ in factors()}
    of_module = {c for c in vars(hw).values() if isinstance(c, type) and issubclass(c, hw.CostFunction)}
    assert of_module == checked | {hw.CostFunction, hw.Factor}


def test_residual_of_a_point_is_its_distance_in_pixels():
    projection = hw.RgbdProjection(CAMERA)
    uv = CAMERA.project(POINT)
    residuals, _ = hw.PointReprojection(uv + [3, -4], np.eye(2), projection).evaluate(hw.Pose(), POINT)
    np.testing.assert_allclose(residuals, [-3, 4], atol=1e-12)


def test_factors_written_in_python_are_not_wrapped():
    factor = hw.Factor(1, [hw.Pose])
    with pytest.raises(hw.InvalidArgument, match="Python"):
        hw.ExtrinsicFactor(factor)
    with pytest.raises(hw.InvalidArgument, match="Python"):
        hw.TimeOffsetFactor(factor, V, V)


def test_values_that_do_not_fit_are_refused():
    prior = hw.PosePrior(hw.Pose(), np.eye(6))
    with pytest.raises(hw.InvalidArgument):
        prior.evaluate(np.zeros(3))
    with pytest.raises(ValueError):
        prior.evaluate(hw.Pose(), hw.Pose())
    with pytest.raises(hw.InvalidArgument, match="Pose"):
        prior.evaluate("pose")


def test_preintegration_at_rest_predicts_rest():
    stamps = np.arange(201) * 5_000_000
    up = np.tile([0, 0, hw.STANDARD_GRAVITY], (201, 1))
    imu = hw.ImuPreintegration(stamps, np.zeros((201, 3)), up)
    assert imu.duration == pytest.approx(1.0)
    end = imu.predict(hw.ImuState(T_WB=hw.Pose(), v_WB=np.zeros(3)), np.zeros(6), [0, 0, -hw.STANDARD_GRAVITY])
    np.testing.assert_allclose(end.T_WB.p, 0, atol=1e-12)
    np.testing.assert_allclose(end.v_WB, 0, atol=1e-12)
    assert imu.covariance.shape == (15, 15)
    with pytest.raises(hw.InvalidArgument, match="length"):
        hw.ImuPreintegration(stamps, np.zeros((200, 3)), up)
