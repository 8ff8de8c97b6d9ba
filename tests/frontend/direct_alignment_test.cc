#include <cmath>
#include <optional>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/so3.h>

#include "painted_world.h"
#include "pose/direct_alignment.h"
#include "support/synthetic_scene.h"

namespace highwall::direct_alignment_test {
namespace {

using testing::kBoxes;
using testing::kGrid;

const DepthNoise kNoise = DepthNoise::Kinect();
const testing::BoxWorld kWall{.wall = 3.0, .floor = 100.0, .boxes = {}};
const Pose kReference = Pose::FromTangent({0.2, 0.1, -0.1}, {0.02, 0.05, -0.03});
const Pose kTruth = kReference * Pose::FromTangent({0.08, -0.06, 0.05}, {0.04, -0.06, 0.03});

std::optional<PoseConstraint> Align(const FrameFeatures& reference, const FrameFeatures& features,
                                    double min_correlation = kMinGreyCorrelation) {
  const auto aligned =
      DirectAligner(kGrid, kNoise, min_correlation)
          .Align(reference, reference.depth_grid, kReference, features, kReference);
  return aligned ? std::optional(aligned->pose) : std::nullopt;
}

TEST(DirectAligner, FindsThePoseOfAMovedCamera) {
  const auto known =
      Align(testing::SeeGrids(kBoxes, kReference), testing::SeeGrids(kBoxes, kTruth));
  ASSERT_TRUE(known);
  // A tenth of a cell at the wall, 4 m away: grey levels are rounded.
  EXPECT_LT(testing::PositionError(known->T_WC, kTruth), 0.004);
  EXPECT_LT(testing::AngleError(known->T_WC, kTruth), 0.001);
}

TEST(DirectAligner, AnotherExposureChangesNothing) {
  const auto known = Align(testing::SeeGrids(kBoxes, kReference),
                           testing::SeeGrids(kBoxes, kTruth, {.gain = 0.5, .offset = 30.0}));
  ASSERT_TRUE(known);
  EXPECT_LT(testing::PositionError(known->T_WC, kTruth), 0.006);  // half the grey levels
  EXPECT_LT(testing::AngleError(known->T_WC, kTruth), 0.0015);
}

TEST(DirectAligner, OnAFlatWallGreyLevelsObserveDirectionsThatDepthDoesNot) {
  const auto known = Align(testing::SeeGrids(kWall, kReference), testing::SeeGrids(kWall, kTruth));
  ASSERT_TRUE(known);
  EXPECT_LT(testing::PositionError(known->T_WC, kTruth), 0.006);
  EXPECT_LT(testing::AngleError(known->T_WC, kTruth), 0.002);
}

TEST(DirectAligner, RefusesAnAlignmentWithAnUnobservableDirection) {
  // The images have almost no texture: motion along the wall is not observable.
  const testing::Light plain{.contrast = 0.005};
  EXPECT_FALSE(Align(testing::SeeGrids(kWall, kReference, plain),
                     testing::SeeGrids(kWall, kTruth, plain), 0.0));
}

TEST(DirectAligner, RefusesAnotherPlaceOfTheSameShape) {
  EXPECT_FALSE(Align(testing::SeeGrids(kBoxes, kReference),
                     testing::SeeGrids(kBoxes, kTruth, {.phase = 1.7})));
}

TEST(DirectAligner, RefusesAViewWithLittleOverlap) {
  const Pose away = kReference * Pose::FromTangent({0, 0, 0}, {0, 0.85, 0});
  const DirectAligner aligner(kGrid, kNoise);
  const FrameFeatures reference = testing::SeeGrids(kBoxes, kReference);
  EXPECT_FALSE(aligner.Align(reference, reference.depth_grid, kReference,
                             testing::SeeGrids(kBoxes, away), away));
}

TEST(DirectAligner, RefusesFeaturesWithoutGrids) {
  EXPECT_FALSE(Align({}, testing::SeeGrids(kBoxes, kTruth)));
  EXPECT_FALSE(Align(testing::SeeGrids(kBoxes, kReference), {}));
}

// A person walks ahead of the camera, in the same cells of both images.
TEST(DirectAligner, LeavesOutDynamicObjectsOfTheReference) {
  FrameFeatures reference = testing::SeeGrids(kBoxes, kReference);
  FrameFeatures features = testing::SeeGrids(kBoxes, kTruth);
  const cv::Rect person(24, 6, 34, 50);
  for (FrameFeatures* seen : {&reference, &features}) {
    for (int v = person.y; v < person.br().y; ++v) {
      for (int u = person.x; u < person.br().x; ++u) {
        seen->depth_grid.at<float>(v, u) = 1.0F;
        seen->gray_grid.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(u * 37 + v * 91);
      }
    }
  }
  const auto error = [&](const cv::Mat& standing) {
    const auto aligned =
        DirectAligner(kGrid, kNoise).Align(reference, standing, kReference, features, kReference);
    return aligned ? (aligned->pose.T_WC.p() - kTruth.p()).norm() : 1.0;
  };
  EXPECT_GT(error(reference.depth_grid), 0.02) << "held by the person";
  cv::Mat standing = reference.depth_grid.clone();
  standing(person).setTo(0.0F);
  // The error is below 10 of 112 mm; the frame's cells of the person next to the masked ones still
  // count.
  EXPECT_LT(error(standing), 0.01);
}

TEST(DirectAligner, IsAsFarOffAsItsInformationSays) {
  std::mt19937 rng(3);
  double mean = 0.0;
  for (int seed = 0; seed < 10; ++seed) {
    const Pose T =
        kReference *
        Pose::FromTangent(testing::UniformInBox(rng, {-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}),
                          testing::UniformInBox(rng, {-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05}));
    FrameFeatures features = testing::SeeGrids(kBoxes, T);
    testing::AddNoise(kNoise, rng, features.depth_grid);
    const auto known = Align(testing::SeeGrids(kBoxes, kReference), features);
    ASSERT_TRUE(known) << seed;
    Eigen::Matrix<double, 6, 1> error;
    error << T.p() - known->T_WC.p(), so3::Log(known->T_WC.q().conjugate() * T.q());
    const double squared = (known->sqrt_information * error).squaredNorm();
    EXPECT_LT(squared, 22.5) << seed << ": 99.9 % of chi-squared with 6 degrees of freedom";
    mean += squared / 10.0;
  }
  // The mean of chi-squared is 6; 3.7 here. With grey levels that share noise it would be 0.6.
  EXPECT_GT(mean, 2.0);
}

}  // namespace
}  // namespace highwall::direct_alignment_test
