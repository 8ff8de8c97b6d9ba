// Variables accepted by each factor: other calls do not compile.

#include <memory>

#include <gtest/gtest.h>

#include <highwall/core/factor_graph.h>
#include <highwall/core/line3.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/pose.h>
#include <highwall/factors/camera_pose.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/factors/line_reprojection.h>
#include <highwall/factors/point_reprojection.h>
#include <highwall/factors/point_to_plane.h>
#include <highwall/factors/scaled_motion.h>
#include <highwall/factors/white_acceleration.h>
#include <highwall/factors/zero_velocity.h>

#include "support/can_add.h"

namespace highwall::variable_types_test {
namespace {

template <class F, class... Ts>
constexpr bool kTakes = CanAdd<FactorGraph, std::unique_ptr<F>, Ts...>;

using Velocity = Eigen::Vector3d;

TEST(VariableTypes, APointFactorTakesAPoseAndAPointOnly) {
  static_assert(kTakes<PointReprojection, Pose, Point>);
  static_assert(kTakes<PointReprojectionRgbd, Pose, Point>);
  static_assert(!kTakes<PointReprojection, Point, Pose>);
  static_assert(!kTakes<PointReprojection, Point, Point>);
  static_assert(!kTakes<PointReprojection, Pose, UnitDirection>);  // of the same size as a point
  static_assert(!kTakes<PointReprojectionRgbd, Pose, UnitDirection>);
  static_assert(!kTakes<PointReprojectionRgbd, Pose, Segment3>);
}

TEST(VariableTypes, ALineFactorTakesTheLineOfItsOwnFormOnly) {
  static_assert(kTakes<LineReprojection, Pose, Segment3>);
  static_assert(kTakes<LineReprojectionRgbd, Pose, Segment3>);
  static_assert(kTakes<OrthonormalLineReprojection, Pose, OrthonormalLine>);
  static_assert(kTakes<OrthonormalLineReprojectionRgbd, Pose, OrthonormalLine>);
  // All of them have six doubles.
  static_assert(!kTakes<LineReprojection, Pose, OrthonormalLine>);
  static_assert(!kTakes<LineReprojectionRgbd, Pose, OrthonormalLine>);
  static_assert(!kTakes<OrthonormalLineReprojection, Pose, Segment3>);
  static_assert(!kTakes<OrthonormalLineReprojectionRgbd, Pose, Segment3>);
  static_assert(!kTakes<LineReprojection, Pose, ImuBias>);
  static_assert(!kTakes<LineReprojection, Point, Segment3>);
}

TEST(VariableTypes, CalibrationAndMotionFactorsTakeTheirOwnOnly) {
  static_assert(kTakes<CameraPose, Pose, Velocity, double>);
  static_assert(!kTakes<CameraPose, Pose, UnitDirection, double>);
  static_assert(kTakes<PointToPlane, Pose, Pose>);
  static_assert(!kTakes<PointToPlane, Pose, Point>);
  static_assert(kTakes<ScaledMotion, Pose, Pose, double>);
  static_assert(!kTakes<ScaledMotion, Pose, Pose, Eigen::Matrix<double, 1, 1>>);
  static_assert(kTakes<WhiteAcceleration, Pose, WhiteAcceleration::Velocities, Pose,  //
                       WhiteAcceleration::Velocities>);
  static_assert(!kTakes<WhiteAcceleration, Pose, Velocity, Pose, Velocity>);
  static_assert(kTakes<ZeroVelocity, Velocity>);
  static_assert(!kTakes<ZeroVelocity, UnitDirection>);
}

TEST(VariableTypes, AnImuFactorTakesTwoStatesInTheirOrder) {
  static_assert(kTakes<ImuFactor, Pose, Velocity, ImuBias, Pose, Velocity, ImuBias>);
  static_assert(!kTakes<ImuFactor, Pose, Velocity, Segment3, Pose, Velocity, ImuBias>);
  static_assert(!kTakes<ImuFactor, Velocity, Pose, ImuBias, Pose, Velocity, ImuBias>);
  static_assert(kTakes<ImuGravityFactor, Pose, Velocity, ImuBias, Pose, Velocity, ImuBias,  //
                       UnitDirection>);
  static_assert(!kTakes<ImuGravityFactor, Pose, Velocity, ImuBias, Pose, Velocity, ImuBias,  //
                        Velocity>);
}

}  // namespace
}  // namespace highwall::variable_types_test
