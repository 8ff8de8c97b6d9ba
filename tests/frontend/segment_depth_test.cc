#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

#include "features/segment_depth.h"

namespace highwall::segment_depth_test {
namespace {

PinholeCamera DistortedCamera() {
  PinholeCamera camera;
  camera.k1 = 0.23;
  camera.k2 = -0.78;
  camera.p1 = -0.003;
  camera.p2 = 0.002;
  camera.k3 = 0.92;
  return camera;
}

// The plane n . p = c as the camera's depth sensor measures it.
struct Plane {
  Eigen::Vector3d n;
  double c;

  double DepthAt(const Eigen::Vector2d& uv, const PinholeCamera& camera) const {
    return c / n.dot(camera.Unproject(uv, 1.0));
  }
};

template <typename DepthOfPixel>
cv::Mat Render(const PinholeCamera& camera, const DepthOfPixel& depth_of_pixel) {
  cv::Mat depth(camera.height, camera.width, CV_32F);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      depth.at<float>(v, u) = static_cast<float>(depth_of_pixel(u, v));
    }
  }
  return depth;
}

cv::Mat Render(const PinholeCamera& camera, const Plane& plane) {
  return Render(camera, [&](int u, int v) { return plane.DepthAt({u, v}, camera); });
}

void AddKinectNoise(cv::Mat* depth, unsigned seed) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> noise;
  const DepthNoise noise_model;
  for (int v = 0; v < depth->rows; ++v) {
    for (int u = 0; u < depth->cols; ++u) {
      float& z = depth->at<float>(v, u);
      z += static_cast<float>(noise_model.Sigma(z) * noise(rng));
    }
  }
}

const Plane kWall{Eigen::Vector3d(0.5, -0.2, 1.0), 2.0};
const LineSegment kSegment{{200.0F, 150.0F}, {330.5F, 220.25F}};

TEST(FitSegmentDepth, FindsTheEndsOnAFrontalPlane) {
  const PinholeCamera camera;
  const cv::Mat depth(480, 640, CV_32F, cv::Scalar(1.5));
  const auto fit = FitSegmentDepth(kSegment, depth, {camera});
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->p_C - camera.Unproject({200.0, 150.0}, 1.5)).norm(), 1e-9);
  EXPECT_LT((fit->q_C - camera.Unproject({330.5, 220.25}, 1.5)).norm(), 1e-9);
  EXPECT_EQ(fit->inlier_share, 1.0);
  EXPECT_LT(fit->rms, 1e-9);
  EXPECT_FALSE(fit->depth_edge);
}

TEST(FitSegmentDepth, FollowsASlantedPlane) {
  const PinholeCamera camera;
  const auto fit = FitSegmentDepth(kSegment, Render(camera, kWall), {camera});
  ASSERT_TRUE(fit);
  // A depth pixel represents a square: half a pixel is 2 mm along this plane, averaged out below.
  EXPECT_NEAR(fit->p_C.z(), kWall.DepthAt({200.0, 150.0}, camera), 1e-3);
  EXPECT_NEAR(fit->q_C.z(), kWall.DepthAt({330.5, 220.25}, camera), 1e-3);
}

// At 60 degrees and a short distance, the surface rises by several sigmas from one side to the
// other.
TEST(FitSegmentDepth, TakesBothSidesOfASteepPlane) {
  const PinholeCamera camera;
  const Plane table{Eigen::Vector3d(0.0, 1.7, 1.0), 0.8};
  const LineSegment segment{{250.0F, 240.0F}, {400.0F, 240.0F}};
  const auto fit = FitSegmentDepth(segment, Render(camera, table), {camera});
  ASSERT_TRUE(fit);
  EXPECT_FALSE(fit->depth_edge);
  EXPECT_EQ(fit->inlier_share, 1.0);
  EXPECT_NEAR(fit->p_C.z(), table.DepthAt({250.0, 240.0}, camera), 1e-5);  // exact model
}

TEST(FitSegmentDepth, SamplesRawPixelsAndReturnsUndistortedRays) {
  const PinholeCamera camera = DistortedCamera();
  const PinholeCamera ideal = camera.WithoutDistortion();
  const LineSegment segment{{30.0F, 40.0F}, {120.0F, 300.0F}};  // 10 px of distortion
  const auto fit = FitSegmentDepth(segment, Render(camera, kWall), {camera});
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->p_C.z(), kWall.DepthAt({30.0, 40.0}, ideal), 2e-3);
  EXPECT_NEAR(fit->q_C.z(), kWall.DepthAt({120.0, 300.0}, ideal), 2e-3);
  EXPECT_LT((ideal.Project(fit->p_C) - Eigen::Vector2d(30.0, 40.0)).norm(), 1e-9);
  EXPECT_LT((ideal.Project(fit->q_C) - Eigen::Vector2d(120.0, 300.0)).norm(), 1e-9);
}

TEST(FitSegmentDepth, TakesTheForegroundSideOfADepthEdge) {
  const PinholeCamera camera;
  const LineSegment edge{{300.0F, 100.0F}, {300.0F, 300.0F}};
  for (const bool left_is_near : {true, false}) {
    const cv::Mat depth =
        Render(camera, [&](int u, int) { return (u < 300) == left_is_near ? 1.2 : 3.0; });
    for (const LineSegment& segment : {edge, LineSegment{edge.e, edge.s}}) {
      const auto fit = FitSegmentDepth(segment, depth, {camera});
      ASSERT_TRUE(fit);
      EXPECT_TRUE(fit->depth_edge);
      EXPECT_NEAR(fit->p_C.z(), 1.2, 1e-6);
      EXPECT_NEAR(fit->q_C.z(), 1.2, 1e-6);
    }
  }
}

// The nearer of two sides of one noisy surface is nearer by chance, and makes a line too near. Here
// one side has 1.3 times the stated noise, the other 1.9 times, which fits no plane well.
TEST(FitSegmentDepth, TakesTheNearerSideOnlyBeyondTheNoise) {
  const PinholeCamera camera;
  const double sigma = DepthNoise().Sigma(2.0);
  const LineSegment edge{{300.0F, 100.0F}, {300.0F, 300.0F}};
  for (const double step : {1.0, 40.0}) {  // [sigmas]
    const bool is_edge = step > 3.0;
    double sum = 0.0;
    constexpr int kSeeds = 50;
    for (int seed = 0; seed < kSeeds; ++seed) {
      std::mt19937 rng(static_cast<unsigned>(seed));
      const cv::Mat depth = Render(camera, [&](int u, int) {
        const double sign = rng() % 2 == 0 ? 1.0 : -1.0;
        return 2.0 + (u < 300 ? 1.3 * sign - 0.5 * step : 1.9 * sign + 0.5 * step) * sigma;
      });
      const auto fit = FitSegmentDepth(edge, depth, {camera});
      ASSERT_TRUE(fit) << seed;
      EXPECT_EQ(fit->depth_edge, is_edge) << seed;
      sum += 0.5 * (fit->p_C.z() + fit->q_C.z()) - 2.0;
    }
    // The mean of some 48 readings of 50 images has a deviation of 0.04 sigmas.
    EXPECT_NEAR(sum / kSeeds / sigma, is_edge ? -0.5 * step : 0.0, 0.12);
  }
}

TEST(FitSegmentDepth, GivesUpWhereTheForegroundIsNoLine) {
  const PinholeCamera camera;
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> clutter(0.8, 1.6);
  const cv::Mat depth = Render(camera, [&](int u, int) { return u < 300 ? clutter(rng) : 3.0; });
  EXPECT_FALSE(FitSegmentDepth({{300.0F, 100.0F}, {300.0F, 300.0F}}, depth, {camera}));
}

TEST(FitSegmentDepth, UsesTheOneSideThatIsMeasured) {
  const PinholeCamera camera;
  const double missing[] = {0.0, std::numeric_limits<double>::quiet_NaN()};
  for (const double nothing : missing) {
    const cv::Mat depth = Render(camera, [&](int u, int) { return u < 300 ? nothing : 2.0; });
    const auto fit = FitSegmentDepth({{300.0F, 100.0F}, {300.0F, 300.0F}}, depth, {camera});
    ASSERT_TRUE(fit);
    EXPECT_NEAR(fit->p_C.z(), 2.0, 1e-6);
  }
}

TEST(FitSegmentDepth, NeedsEnoughMeasurements) {
  const PinholeCamera camera;
  EXPECT_FALSE(FitSegmentDepth(kSegment, cv::Mat(480, 640, CV_32F, cv::Scalar(0)), {camera}));
  const LineSegment segment{{100.0F, 200.0F}, {300.0F, 200.0F}};
  const auto measured_up_to = [&](int limit) {
    return Render(camera, [=](int u, int) { return u < limit ? 2.0 : 0.0; });
  };
  EXPECT_TRUE(FitSegmentDepth(segment, measured_up_to(220), {camera}));   // 60 %
  EXPECT_FALSE(FitSegmentDepth(segment, measured_up_to(180), {camera}));  // 40 %
  EXPECT_TRUE(FitSegmentDepth(segment, measured_up_to(180), {camera}, 0.3));
}

TEST(FitSegmentDepth, IgnoresDepthOutOfRange) {
  const PinholeCamera camera;
  const cv::Mat depth(480, 640, CV_32F, cv::Scalar(2.0));
  EXPECT_FALSE(FitSegmentDepth(kSegment, depth, {.camera = camera, .max_depth = 1.9}));
  EXPECT_FALSE(FitSegmentDepth(kSegment, depth, {.camera = camera, .min_depth = 2.1}));
}

TEST(FitSegmentDepth, ResistsOutliers) {
  const PinholeCamera camera;
  std::mt19937 rng(4);
  std::uniform_real_distribution<double> chance(0.0, 1.0), wrong(0.5, 5.0);
  const cv::Mat depth = Render(camera, [&](int u, int v) {
    return chance(rng) < 0.25 ? wrong(rng) : kWall.DepthAt({u, v}, camera);
  });
  const auto fit = FitSegmentDepth(kSegment, depth, {camera});
  ASSERT_TRUE(fit);
  EXPECT_LT(fit->inlier_share, 0.9);
  EXPECT_NEAR(fit->p_C.z(), kWall.DepthAt({200.0, 150.0}, camera), 3e-3);
  EXPECT_NEAR(fit->q_C.z(), kWall.DepthAt({330.5, 220.25}, camera), 3e-3);
}

TEST(FitSegmentDepth, RejectsEdgesThatAreNotStraightInSpace) {
  const PinholeCamera camera;
  // Steps of 20 cm along the segment.
  const cv::Mat depth = Render(camera, [](int u, int) { return 1.5 + 0.2 * (u / 30 % 2); });
  EXPECT_FALSE(FitSegmentDepth({{100.0F, 200.0F}, {400.0F, 200.0F}}, depth, {camera}));
}

// A user of sigma_p and sigma_q must neither overweight the ends nor underweight them. The noise
// here is independent between pixels, four of which count as one: the errors are half as large as
// stated.
TEST(FitSegmentDepth, StatesItsUncertainty) {
  const PinholeCamera camera;
  const cv::Mat clean = Render(camera, kWall);
  const double truth = kWall.DepthAt({200.0, 150.0}, camera);
  double sum = 0.0;
  constexpr int kTrials = 60;
  for (unsigned i = 0; i < kTrials; ++i) {
    cv::Mat depth = clean.clone();
    AddKinectNoise(&depth, i);
    const auto fit = FitSegmentDepth(kSegment, depth, {camera});
    ASSERT_TRUE(fit);
    const double error = (fit->p_C.z() - truth) / fit->sigma_p;
    sum += error * error;
  }
  const double rms = std::sqrt(sum / kTrials);
  EXPECT_GT(rms, 0.35);
  EXPECT_LT(rms, 0.8);
}

TEST(FitSegmentDepth, IsDeterministic) {
  const PinholeCamera camera;
  cv::Mat depth = Render(camera, kWall);
  AddKinectNoise(&depth, 5);
  const auto a = FitSegmentDepth(kSegment, depth, {camera});
  const auto b = FitSegmentDepth(kSegment, depth, {camera});
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->p_C, b->p_C);
  EXPECT_EQ(a->q_C, b->q_C);
}

TEST(FitSegmentDepth, ToleratesSegmentsOutsideOfTheImageAndPoints) {
  const PinholeCamera camera;
  const cv::Mat depth(480, 640, CV_32F, cv::Scalar(2.0));
  EXPECT_FALSE(FitSegmentDepth({{-300.0F, -20.0F}, {-100.0F, -20.0F}}, depth, {camera}));
  EXPECT_FALSE(FitSegmentDepth({{700.0F, 500.0F}, {900.0F, 490.0F}}, depth, {camera}));
  EXPECT_FALSE(FitSegmentDepth({{100.0F, 100.0F}, {100.2F, 100.0F}}, depth, {camera}));
  EXPECT_TRUE(FitSegmentDepth({{0.0F, 0.0F}, {639.0F, 479.0F}}, depth, {camera}));
}

TEST(FitSegmentDepth, RejectsBadArguments) {
  const PinholeCamera camera;
  const cv::Mat depth(480, 640, CV_32F, cv::Scalar(2.0));
  EXPECT_THROW(FitSegmentDepth(kSegment, cv::Mat(), {camera}), InvalidArgument);
  EXPECT_THROW(FitSegmentDepth(kSegment, depth.rowRange(0, 240), {camera}), InvalidArgument);
  EXPECT_THROW(FitSegmentDepth(kSegment, cv::Mat(480, 640, CV_16U, cv::Scalar(1)), {camera}),
               InvalidArgument);
  EXPECT_THROW(FitSegmentDepth({{std::nanf(""), 0.0F}, {1.0F, 1.0F}}, depth, {camera}),
               InvalidArgument);
}

}  // namespace
}  // namespace highwall::segment_depth_test
