#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/pose/pose_solver.h>

#include "pose/degeneracy.h"
#include "support/synthetic_scene.h"

namespace highwall::degeneracy_test {
namespace {

using testing::IdealSensor;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Rotated with respect to the world, so that directions in C and in W differ.
const Pose kCamera = Pose::FromTangent({0.5, -0.2, 0.3}, {0.2, -0.3, 0.4});

// Information of a camera at kCamera about its pose. Points and lines are in C.
class Degeneracy : public ::testing::Test {
 protected:
  void AddPoint(const Eigen::Vector3d& p_C) {
    PointFeature feature;
    feature.uv = sensor.camera.Project(p_C);
    feature.depth = p_C.z();
    feature.depth_sigma = sensor.depth_noise.Sigma(p_C.z());
    seen.points.push_back({kCamera * p_C, model.Rows(feature), 3});
  }
  void AddLine(const Eigen::Vector3d& p_C, const Eigen::Vector3d& q_C) {
    LineFeature feature;
    feature.segment = {sensor.camera.Project(p_C).cast<float>(),
                       sensor.camera.Project(q_C).cast<float>()};
    feature.segment_C.emplace();
    feature.segment_C->p_C = p_C;
    feature.segment_C->q_C = q_C;
    seen.lines.push_back({Segment3(kCamera * p_C, kCamera * q_C), model.Rows(feature), 4});
  }
  std::vector<UnobservableDirection> Open() const {
    const auto solution = SolvePose(kCamera, model.projection(), seen);
    if (!solution) ADD_FAILURE() << "no pose";
    return FindUnobservableDirections(solution->information, kCamera, 3.0);
  }

  const RgbdSensor sensor = IdealSensor();
  const MeasurementModel model{sensor, {}};
  PerKind<PoseObservations> seen;
};

TEST_F(Degeneracy, AWallWithParallelLinesLeavesTheDirectionAlongThemOpen) {
  const Eigen::Vector3d along = Eigen::Vector3d(1.0, 0.3, 0.0).normalized();
  for (int i = -10; i <= 10; ++i) {
    const Eigen::Vector3d middle(0.03 * i, 0.1 * i, 3.0);
    AddLine(middle - 0.8 * along, middle + 0.8 * along);
  }
  const auto open = Open();
  ASSERT_EQ(open.size(), 1U);
  // Pixels are floats: the lines are parallel to 1e-7, and the information of the rest is 1e8.
  EXPECT_GT(std::abs(open[0].translation_C.dot(along)), 1.0 - 1e-6);
  EXPECT_LT(open[0].rotation_C.norm(), 1e-3);
  EXPECT_GT(open[0].sigma, 0.5);
}

TEST_F(Degeneracy, LinesOfTwoDirectionsLeaveNoneOpen) {
  for (int i = -3; i <= 3; ++i) {
    AddLine({-0.8, 0.3 * i, 3.0}, {0.8, 0.3 * i, 3.0});
    AddLine({0.3 * i, -0.8, 3.0}, {0.3 * i, 0.8, 3.0});
  }
  EXPECT_TRUE(Open().empty());
}

TEST_F(Degeneracy, ATexturedBoxLeavesNoneOpen) {
  // The front of the object and one side.
  for (int i = -3; i <= 3; ++i) {
    for (int j = -3; j <= 3; ++j) {
      AddPoint({0.3 * i, 0.3 * j, 2.5});
      AddPoint({1.0, 0.3 * j, 3.0 + 0.15 * i});
    }
  }
  EXPECT_TRUE(Open().empty());
}

TEST_F(Degeneracy, RotationCountsByTheMotionOfTheScene) {
  // A rotation of 5 mrad about x moves a point by 5 mm at 1 m, by 5 cm at 10 m.
  Matrix6 information = 1e8 * Matrix6::Identity();
  information(3, 3) = 1.0 / (0.005 * 0.005);
  EXPECT_TRUE(FindUnobservableDirections(information, kCamera, 1.0).empty());
  const auto open = FindUnobservableDirections(information, kCamera, 10.0);
  ASSERT_EQ(open.size(), 1U);
  EXPECT_NEAR(open[0].sigma, 0.05, 1e-12);
  EXPECT_NEAR(std::abs(open[0].rotation_C.x()), 1.0, 1e-12);
}

TEST_F(Degeneracy, TranslationIsTheCameras) {
  // The direction is z of the world.
  Matrix6 information = 1e8 * Matrix6::Identity();
  information(2, 2) = 1.0 / (0.04 * 0.04);
  const auto open = FindUnobservableDirections(information, kCamera, 2.0);
  ASSERT_EQ(open.size(), 1U);
  EXPECT_NEAR(open[0].sigma, 0.04, 1e-12);
  const Eigen::Vector3d z_C = kCamera.R().transpose() * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(std::abs(open[0].translation_C.dot(z_C)), 1.0, 1e-12);
}

TEST_F(Degeneracy, TheLeastObservableDirectionComesFirstAndAnUnknownOneIsInfinite) {
  Matrix6 information = 1e6 * Matrix6::Identity();
  information(0, 0) = 400.0;  // 5 cm
  information(1, 1) = 0.0;
  information(2, 2) = 100.0;  // 10 cm
  const auto open = FindUnobservableDirections(information, Pose(), 2.0);
  ASSERT_EQ(open.size(), 3U);
  EXPECT_EQ(open[0].sigma, std::numeric_limits<double>::infinity());
  EXPECT_NEAR(open[1].sigma, 0.1, 1e-12);
  EXPECT_NEAR(open[2].sigma, 0.05, 1e-12);
  EXPECT_EQ(FindUnobservableDirections(information, Pose(), 2.0, {.max_sigma = 0.07}).size(), 2U);
}

TEST_F(Degeneracy, RefusesBadArguments) {
  const Matrix6 I = Matrix6::Identity();
  EXPECT_THROW(FindUnobservableDirections(I, Pose(), 0.0), InvalidArgument);
  EXPECT_THROW(FindUnobservableDirections(I * std::nan(""), Pose(), 1.0), InvalidArgument);
  EXPECT_THROW(DegeneracyOptions{.max_sigma = 0.0}.Validate(), InvalidArgument);
}

}  // namespace
}  // namespace highwall::degeneracy_test
