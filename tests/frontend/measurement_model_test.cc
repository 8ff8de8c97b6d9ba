#include <highwall/frontend/map/measurement_model.h>

#include <cmath>

#include <gtest/gtest.h>
#include <highwall/core/error.h>

#include "support/synthetic_scene.h"

namespace highwall::measurement_model_test {
namespace {

using testing::IdealSensor;
using testing::MakeScene;
using testing::SyntheticView;

const Pose kPose = Pose::FromTangent({0.1, -0.2, 0.3}, {0.05, -0.04, 0.1});

// Returns the rows of a feature at a world point that is off by a few centimetres.
Eigen::Vector3d Residual(const MeasurementModel& model, const PointFeature& feature,
                         const Eigen::Vector3d& p_W) {
  Eigen::Vector3d r;
  EXPECT_TRUE(model.projection().Evaluate<3>(RgbdProjection::At(kPose.data()), model.Rows(feature),
                                             p_W, &r, nullptr, nullptr));
  return r;
}

TEST(MeasurementModel, PointSigmaGrowsWithTheLevel) {
  const MeasurementModel model(IdealSensor(), {.point_sigma = 0.7}, Pose(), {.scale_factor = 1.5});
  EXPECT_DOUBLE_EQ(model.PointSigma(0), 0.7);
  EXPECT_DOUBLE_EQ(model.PointSigma(2), 0.7 * 2.25);
}

TEST(MeasurementModel, DisparitySigmaIsThatOfDepthToFirstOrder) {
  const MeasurementModel model(IdealSensor(), {.baseline = 0.1});
  // sigma_delta = fx b / z^2 sigma_z, computed by hand.
  EXPECT_NEAR(model.DisparitySigma(2.0, 0.006), 525.0 * 0.1 / 4.0 * 0.006, 1e-15);
}

TEST(MeasurementModel, FactorsAreOfTheExtrinsicsThatWereSetLast) {
  const Pose T_BC = Pose::FromTangent({0.05, 0.1, -0.1}, {0.2, -0.1, 0.3});
  const Pose T_WB = kPose * T_BC.Inverse();
  const auto scene = MakeScene(5, 40, 0);
  const SyntheticView view = Look(scene, IdealSensor(), kPose);
  ASSERT_GT(view.features->points.size(), 0u);
  MeasurementModel model(IdealSensor(), {});
  model.SetExtrinsics(T_BC);
  EXPECT_EQ(model.T_BC().Matrix(), T_BC.Matrix());
  const Eigen::Vector3d p_W = kPose * Eigen::Vector3d(0.1, -0.2, 3.0);
  for (const PointFeature& feature : view.features->points) {
    Eigen::Vector3d r;
    const double* blocks[] = {T_WB.data(), p_W.data()};
    ASSERT_TRUE(model.MakeFactor(feature)->Evaluate(blocks, r.data(), nullptr));
    const Eigen::Vector3d rows = Residual(model, feature, p_W);
    EXPECT_LT((r - rows).norm(), 1e-9 * rows.norm());  // hundreds of pixels, composed poses
  }
}

TEST(MeasurementModel, CameraHasNoDistortion) {
  RgbdSensor sensor = IdealSensor();
  sensor.camera.k1 = 0.2;
  const MeasurementModel model(sensor, {});
  EXPECT_FALSE(model.camera().HasDistortion());
  EXPECT_EQ(model.camera().fx, sensor.camera.fx);
}

TEST(MeasurementModel, RowsOfAPointAreWhitenedErrors) {
  const MeasurementModel model(IdealSensor(), {.point_sigma = 1.0});
  PointFeature feature{.uv = {300.0, 200.0}, .depth = 2.0, .depth_sigma = 0.01, .octave = 2};
  const Eigen::Vector3d p_C = model.camera().Unproject({303.0, 196.0}, 2.1);
  const double sigma = 1.44, delta = 525.0 * 0.08;
  const Eigen::Vector3d with_depth = Residual(model, feature, kPose * p_C);
  // The coordinates are hundreds of pixels: 1e-12.
  EXPECT_NEAR(with_depth[0], 3.0 / sigma, 1e-11);
  EXPECT_NEAR(with_depth[1], -4.0 / sigma, 1e-11);
  EXPECT_NEAR(with_depth[2], (delta / 2.1 - delta / 2.0) / model.DisparitySigma(2.0, 0.01), 1e-10);
  EXPECT_EQ(MeasurementModel::Dimension(feature), 3);
  feature.depth = 0.0;
  const Eigen::Vector3d without = Residual(model, feature, kPose * p_C);
  EXPECT_NEAR(without[0], 3.0 / sigma, 1e-11);
  EXPECT_NEAR(without[1], -4.0 / sigma, 1e-11);
  EXPECT_EQ(without[2], 0.0);
  EXPECT_EQ(MeasurementModel::Dimension(feature), 2);
}

// The rows for the pose alone and the factors of bundle adjustment must be the same measurement.
TEST(MeasurementModel, PointFactorEqualsItsRows) {
  for (const Weighting weighting : {Weighting::kCovariance, Weighting::kPaper}) {
    const MeasurementModel model(IdealSensor(), {.weighting = weighting});
    for (const double depth : {0.0, 1.9}) {
      const PointFeature feature{
          .uv = {300.0, 200.0}, .depth = depth, .depth_sigma = 0.01, .octave = 1};
      const Eigen::Vector3d p_W = kPose * model.camera().Unproject({305.0, 190.0}, 2.0);
      const Eigen::Vector3d rows = Residual(model, feature, p_W);
      const auto factor = model.MakeFactor(feature);
      ASSERT_EQ(factor->num_residuals(), MeasurementModel::Dimension(feature));
      Eigen::Vector3d r = Eigen::Vector3d::Zero();
      const double* blocks[] = {kPose.data(), p_W.data()};
      ASSERT_TRUE(factor->Evaluate(blocks, r.data(), nullptr));
      EXPECT_TRUE(r.isApprox(rows, 1e-13)) << r.transpose() << " / " << rows.transpose();
    }
  }
}

// The end-point form measures at the points of the map line seen by the observed ends, the
// orthonormal form at the observed ends: on the true line both vanish.
TEST(MeasurementModel, LineRowsAndFactorVanishOnTheTrueLine) {
  const auto scene = MakeScene(5, 0, 40);
  const SyntheticView view = Look(scene, IdealSensor(), kPose);
  ASSERT_GT(view.lines.size(), 10u);
  for (const Weighting weighting : {Weighting::kCovariance, Weighting::kPaper}) {
    const MeasurementModel model(IdealSensor(), {.weighting = weighting});
    for (const bool depth : {true, false}) {
      for (std::size_t i = 0; i < view.lines.size(); ++i) {
        const Segment3& truth = scene.lines[static_cast<std::size_t>(view.lines[i])].segment_W;
        LineFeature feature = view.features->lines[i];
        const std::array<Eigen::Vector3d, 2> ends_W{kPose * feature.segment_C->p_C,
                                                    kPose * feature.segment_C->q_C};
        if (!depth) feature.segment_C.reset();
        ASSERT_EQ(MeasurementModel::Dimension(feature), depth ? 4 : 2);
        const auto rows = model.Rows(feature);
        for (std::size_t end = 0; end < 2; ++end) {
          Eigen::Vector2d r;
          ASSERT_TRUE(model.projection().Evaluate<2>(RgbdProjection::At(kPose.data()), rows[end],
                                                     ends_W[end], &r, nullptr, nullptr));
          EXPECT_LT(r.norm(), 1e-3);  // float pixels, 3e-5 px, over sigmas down to 0.03 px
          if (!depth) {
            EXPECT_EQ(r[1], 0.0);
          }
        }
        const OrthonormalLine line(PluckerLine::FromPoints(truth.p(), truth.q()));
        const auto factor = model.MakeFactor(feature);
        ASSERT_EQ(factor->num_residuals(), MeasurementModel::Dimension(feature));
        Eigen::Vector4d r = Eigen::Vector4d::Zero();
        const double* blocks[] = {kPose.data(), line.data()};
        ASSERT_TRUE(factor->Evaluate(blocks, r.data(), nullptr));
        EXPECT_LT(r.norm(), 2e-3);
      }
    }
  }
}

// u - delta is the same for both ends: the right camera looks along the segment.
TEST(MeasurementModel, SegmentSeenEndOnFromTheRightHasNoRowsThereWithPaperWeighting) {
  const MeasurementModel paper(IdealSensor(), {.weighting = Weighting::kPaper});
  const double fxb = paper.camera().fx * paper.options().baseline;
  const double delta = fxb / 2.0;
  LineFeature feature;
  feature.segment = {{300, 200}, {320, 200}};
  SegmentDepth ends;
  ends.p_C = paper.camera().Unproject({300, 200}, fxb / delta);
  ends.q_C = paper.camera().Unproject({320, 200}, fxb / (delta + 20.0));
  feature.segment_C = ends;
  for (const ProjectionRows<2>& end : paper.Rows(feature)) {
    EXPECT_GT(end.A.row(0).norm(), 0.0);
    EXPECT_EQ(end.A.row(1).norm(), 0.0);
    EXPECT_EQ(end.b(1), 0.0);
  }
  const MeasurementModel covariance(IdealSensor(), {.weighting = Weighting::kCovariance});
  for (const ProjectionRows<2>& end : covariance.Rows(feature)) {
    EXPECT_GT(end.A.row(1).norm(), 0.0);
  }
}

TEST(MeasurementModel, LineRowIsTheDistanceAcrossInSigmas) {
  const MeasurementModel model(IdealSensor(), {.line_sigma = 2.0});
  LineFeature feature;
  feature.segment = {{100, 100}, {200, 100}};
  const auto rows = model.Rows(feature);
  Eigen::Vector2d r;
  const Eigen::Vector3d p_W = kPose * model.camera().Unproject({120.0, 106.0}, 2.0);
  ASSERT_TRUE(model.projection().Evaluate<2>(RgbdProjection::At(kPose.data()), rows[0], p_W, &r,
                                             nullptr, nullptr));
  EXPECT_NEAR(std::abs(r[0]), 3.0, 1e-11);
  EXPECT_EQ(r[1], 0.0);
}

TEST(MeasurementModel, RefusesABadPyramid) {
  EXPECT_THROW(MeasurementModel(IdealSensor(), {}, Pose(), {.scale_factor = 1.0}), InvalidArgument);
}

}  // namespace
}  // namespace highwall::measurement_model_test
