#include <limits>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include <highwall/core/error.h>
#include <highwall/factors/depth_noise.h>

namespace highwall::depth_noise_test {
namespace {

TEST(DepthNoise, KinectMatchesThePublishedPolynomial) {
  const DepthNoise noise = DepthNoise::Kinect();
  EXPECT_DOUBLE_EQ(noise.Sigma(0.4), 0.0012);
  EXPECT_NEAR(noise.Sigma(2.0), 0.0012 + 0.0019 * 1.6 * 1.6, 1e-17);
  EXPECT_NEAR(noise.Sigma(3.4), 0.0183, 1e-16);
}

TEST(DepthNoise, StereoGrowsWithTheSquareOfDepth) {
  const DepthNoise noise = DepthNoise::Stereo(0.1, 400.0, 0.05);
  EXPECT_NEAR(noise.Sigma(2.0), 0.1 * 4.0 / (400.0 * 0.05), 1e-16);  // 20 mm
  EXPECT_NEAR(noise.Sigma(4.0), 4.0 * noise.Sigma(2.0), 1e-15);
}

TEST(DepthNoise, StereoNoiseIsConstantInDisparity) {
  // The virtual pair has the sensor's own subpixel noise, scaled by the ratio of the two focal
  // baselines.
  const DepthNoise noise = DepthNoise::Stereo(0.1, 400.0, 0.05);
  const VirtualRightCamera right{.fx = 600.0, .baseline = 0.1};
  for (const double d : {0.3, 1.0, 3.0}) {
    EXPECT_NEAR(noise.DisparitySigma(d, right), 0.1 * 60.0 / 20.0, 1e-14) << d;
  }
}

TEST(DepthNoise, DisparitySigmaIsTheSpreadOfDisparitiesOfNoisyDepths) {
  const DepthNoise noise = DepthNoise::Kinect();
  const VirtualRightCamera right{.fx = 525.0, .baseline = 0.08};
  std::mt19937 rng(3);
  for (const double d : {0.8, 2.0, 3.0}) {
    std::normal_distribution<double> depth(d, noise.Sigma(d));
    double sum = 0.0, squares = 0.0;
    constexpr int kSamples = 20000;
    for (int i = 0; i < kSamples; ++i) {
      const double error = right.Disparity(depth(rng)) - right.Disparity(d);
      sum += error;
      squares += error * error;
    }
    const double mean = sum / kSamples;
    const double sigma = std::sqrt(squares / kSamples - mean * mean);
    // 20000 samples determine a standard deviation to 0.5 % (one sigma).
    EXPECT_NEAR(sigma / noise.DisparitySigma(d, right), 1.0, 0.02) << d;
  }
}

TEST(DepthNoise, EqualSigmasUnderweightDepthThirteenfoldAtTwoMetres) {
  // A common sigma for (u, v, u_R) weights depth too weakly: docs/equations.md, section 3.
  const VirtualRightCamera right{.fx = 525.0, .baseline = 0.08};
  const double sigma_delta = DepthNoise::Kinect().DisparitySigma(2.0, right);
  EXPECT_NEAR(1.0 / sigma_delta, 15.7, 0.1);
}

TEST(DepthNoise, ValidateNamesTheField) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto message = [](const DepthNoise& noise) -> std::string {
    try {
      noise.Validate();
    } catch (const InvalidArgument& e) {
      return e.what();
    }
    return {};
  };
  EXPECT_EQ(message({}), "");
  EXPECT_EQ(message({.offset = 0.0, .reference = 0.0}), "");
  // Sigma(reference) would be zero, but its inverse is a weight.
  EXPECT_NE(message({.offset = 0.0}).find("DepthNoise::offset"), std::string::npos);
  EXPECT_NE(message({.offset = -0.1}).find("DepthNoise::offset"), std::string::npos);
  EXPECT_NE(message({.quadratic = nan}).find("DepthNoise::quadratic"), std::string::npos);
  EXPECT_NE(message({.reference = -1.0}).find("DepthNoise::reference"), std::string::npos);
  EXPECT_NE(message({.offset = 0.0, .quadratic = 0.0}).find("both"), std::string::npos);
  EXPECT_THROW(DepthNoise::Stereo(0.0, 400.0, 0.05), InvalidArgument);
  EXPECT_THROW(DepthNoise::Stereo(0.1, -1.0, 0.05), InvalidArgument);
  EXPECT_THROW(DepthNoise::Stereo(0.1, 400.0, nan), InvalidArgument);
}

TEST(PointSqrtInformation, CovarianceWeightsEachRowByItsOwnSigma) {
  const Eigen::Matrix3d W = PointSqrtInformation(Weighting::kCovariance, 2.0, 0.25);
  const Eigen::Matrix3d expected = Eigen::Vector3d(0.5, 0.5, 4.0).asDiagonal();
  EXPECT_EQ(W, expected);
}

TEST(PointSqrtInformation, PaperGivesRowsOfTheRightImageWithOneSigma) {
  const Eigen::Matrix3d W = PointSqrtInformation(Weighting::kPaper, 2.0, 0.25);
  // Errors of (4, 6) px of the pixel and 10 px of the disparity: the error of u_R is 4 - 10.
  EXPECT_EQ(W * Eigen::Vector3d(4.0, 6.0, 10.0), Eigen::Vector3d(2.0, 3.0, -3.0));
}

TEST(PointSqrtInformation, RefusesSigmasThatAreNotPositive) {
  EXPECT_THROW(PointSqrtInformation(Weighting::kCovariance, 0.0, 1.0), InvalidArgument);
  EXPECT_THROW(PointSqrtInformation(Weighting::kCovariance, 1.0, -1.0), InvalidArgument);
  EXPECT_THROW(
      PointSqrtInformation(Weighting::kPaper, std::numeric_limits<double>::infinity(), 1.0),
      InvalidArgument);
}

TEST(Weighting, HasNames) {
  EXPECT_STREQ(ToString(Weighting::kCovariance), "covariance");
  EXPECT_STREQ(ToString(Weighting::kPaper), "paper");
}

}  // namespace
}  // namespace highwall::depth_noise_test
