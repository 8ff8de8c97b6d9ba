"""Factors, their losses, and the readings of an IMU."""

from typing import ClassVar, Dict, List, Sequence, Tuple, Union

import numpy.typing as npt

from ._geometry import Pose, RgbdProjection, SegmentNoise, UnitDirection
from ._types import Array, Value

class CameraPose(CostFunction):
    def __init__(
        self, T_WC_0: Pose, sqrt_information: npt.ArrayLike, T_BC: Pose, omega_B: npt.ArrayLike,
        t_d_state: float = ...
    ) -> None: ...

class CauchyLoss(LossFunction):
    def __init__(self, delta: float) -> None: ...

class CostFunction:
    def evaluate(self, *values: Value) -> Tuple[Array, List[Array]]: ...
    @property
    def num_residuals(self) -> int: ...

class DirectionPrior(CostFunction):
    def __init__(self, n_0: UnitDirection, sigma: float) -> None: ...

class ExtrinsicCameraPose(CostFunction):
    def __init__(
        self, T_WC_0: Pose, sqrt_information: npt.ArrayLike, omega_B: npt.ArrayLike,
        t_d_state: float = ...
    ) -> None: ...

class Factor(CostFunction):
    def __init__(self, residuals: int, types: Sequence[Union[type, int]]) -> None: ...

class HuberLoss(LossFunction):
    def __init__(self, delta: float) -> None: ...

class ImuCalibration:
    T_BC: Pose
    noise: ImuNoise
    rate: float
    time_offset: float
    gyroscope_range: float
    accelerometer_range: float
    def __init__(
        self, *, T_BC: Pose = ..., noise: ImuNoise = ..., rate: float = ...,
        time_offset: float = ...,
        gyroscope_range: float = ..., accelerometer_range: float = ...
    ) -> None: ...

class ImuFactor(CostFunction):
    def __init__(
        self, imu: ImuPreintegration, gravity_W: npt.ArrayLike, weight: float = ...
    ) -> None: ...

class ImuGravityFactor(CostFunction):
    def __init__(
        self, imu: ImuPreintegration, gravity: float = ..., weight: float = ...
    ) -> None: ...

class ImuNoise:
    accelerometer: float
    accelerometer_walk: float
    gyroscope: float
    gyroscope_walk: float
    def __init__(
        self, *, accelerometer: float = ..., accelerometer_walk: float = ...,
        gyroscope: float = ..., gyroscope_walk: float = ...
    ) -> None: ...

class ImuPreintegration:
    def __init__(
        self, stamps: npt.ArrayLike, gyroscope: npt.ArrayLike, accelerometer: npt.ArrayLike,
        bias: npt.ArrayLike = ..., noise: ImuNoise = ...
    ) -> None: ...
    def needs_reintegration(self, bias: npt.ArrayLike) -> bool: ...
    def predict(
        self, start: ImuState, bias: npt.ArrayLike, gravity_W: npt.ArrayLike
    ) -> ImuState: ...
    def reintegrated(self, bias: npt.ArrayLike) -> ImuPreintegration: ...
    @property
    def bias_jacobian(self) -> Array: ...
    @property
    def covariance(self) -> Array: ...
    @property
    def duration(self) -> float: ...
    @property
    def p(self) -> Array: ...
    @property
    def q_xyzw(self) -> Array: ...
    @property
    def v(self) -> Array: ...

class ImuSample:
    accelerometer: Array
    gyroscope: Array
    stamp: int
    def __init__(
        self, stamp: int, gyroscope: npt.ArrayLike, accelerometer: npt.ArrayLike
    ) -> None: ...

class ImuState:
    T_WB: Pose
    v_WB: Array
    def __init__(self, T_WB: Pose, v_WB: npt.ArrayLike) -> None: ...

class JacobianCheckResult:
    def __bool__(self) -> bool: ...
    @property
    def message(self) -> str: ...
    @property
    def ok(self) -> bool: ...

class LineReprojection(CostFunction):
    def __init__(
        self, s: npt.ArrayLike, e: npt.ArrayLike, sigma_px: float, projection: RgbdProjection
    ) -> None: ...

class LineReprojectionRgbd(CostFunction):
    def __init__(
        self, s: npt.ArrayLike, e: npt.ArrayLike, projection: RgbdProjection,
        noise: SegmentNoise = ..., weighting: Weighting = ...
    ) -> None: ...

class LossFunction: ...

class OrthonormalLineReprojection(CostFunction):
    def __init__(
        self, s: npt.ArrayLike, e: npt.ArrayLike, sigma_px: float, projection: RgbdProjection
    ) -> None: ...

class OrthonormalLineReprojectionRgbd(CostFunction):
    def __init__(
        self, s: npt.ArrayLike, e: npt.ArrayLike, projection: RgbdProjection,
        noise: SegmentNoise = ..., weighting: Weighting = ...
    ) -> None: ...

class PointInFrame(CostFunction):
    def __init__(self, p_F: npt.ArrayLike, sqrt_information: npt.ArrayLike) -> None: ...

class PointReprojection(CostFunction):
    def __init__(
        self, uv: npt.ArrayLike, sqrt_information: npt.ArrayLike, projection: RgbdProjection
    ) -> None: ...

class PointReprojectionExtrinsics(CostFunction):
    def __init__(
        self, uv: npt.ArrayLike, sqrt_information: npt.ArrayLike, projection: RgbdProjection
    ) -> None: ...

class PointReprojectionRgbd(CostFunction):
    def __init__(
        self, uvd: npt.ArrayLike, sqrt_information: npt.ArrayLike, projection: RgbdProjection
    ) -> None: ...

class PointReprojectionRgbdExtrinsics(CostFunction):
    def __init__(
        self, uvd: npt.ArrayLike, sqrt_information: npt.ArrayLike, projection: RgbdProjection
    ) -> None: ...

class PointReprojectionRgbdTimeOffset(CostFunction):
    def __init__(
        self, uvd: npt.ArrayLike, velocity: npt.ArrayLike, sqrt_information: npt.ArrayLike,
        projection: RgbdProjection, t_d_state: float = ...
    ) -> None: ...

class PointReprojectionTimeOffset(CostFunction):
    def __init__(
        self, uv: npt.ArrayLike, velocity: npt.ArrayLike, sqrt_information: npt.ArrayLike,
        projection: RgbdProjection, t_d_state: float = ...
    ) -> None: ...

class PointToPlane(CostFunction):
    def __init__(
        self, n: npt.ArrayLike, a: npt.ArrayLike, p: npt.ArrayLike, sigma: float
    ) -> None: ...

class PosePrior(CostFunction):
    def __init__(self, T_0: Pose, sqrt_information: npt.ArrayLike) -> None: ...

class PositionFactor(CostFunction):
    def __init__(
        self, p_G: npt.ArrayLike, lever_arm: npt.ArrayLike, sqrt_information: npt.ArrayLike
    ) -> None: ...

class RelativePose(CostFunction):
    def __init__(self, Z: Pose, sqrt_information: npt.ArrayLike) -> None: ...

class ScaledMotion(CostFunction):
    def __init__(self, Z: Pose, sqrt_information: npt.ArrayLike, T_BC: Pose = ...) -> None: ...

class GravityPrior(CostFunction):
    def __init__(self, sigma: float) -> None: ...

class VectorPrior1(CostFunction):
    def __init__(self, x_0: npt.ArrayLike, sqrt_information: npt.ArrayLike) -> None: ...

class VectorPrior2(CostFunction):
    def __init__(self, x_0: npt.ArrayLike, sqrt_information: npt.ArrayLike) -> None: ...

class VectorPrior3(CostFunction):
    def __init__(self, x_0: npt.ArrayLike, sqrt_information: npt.ArrayLike) -> None: ...

class VectorPrior6(CostFunction):
    def __init__(self, x_0: npt.ArrayLike, sqrt_information: npt.ArrayLike) -> None: ...

class Weighting:
    __members__: ClassVar[Dict[str, Weighting]]
    COVARIANCE: ClassVar[Weighting]
    PAPER: ClassVar[Weighting]
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...
    def __int__(self) -> int: ...

class ZeroVelocity(CostFunction):
    def __init__(self, sigma: float = ...) -> None: ...

def check_jacobians(
    factor: CostFunction, *values: Value, step: float = ..., absolute: float = ...,
    relative: float = ...
) -> JacobianCheckResult: ...
def point_sqrt_information(
    weighting: Weighting, sigma_px: float, sigma_disparity: float
) -> Array: ...
def sqrt_information(covariance: npt.ArrayLike) -> Array: ...
