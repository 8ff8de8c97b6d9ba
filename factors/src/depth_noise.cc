#include <highwall/factors/depth_noise.h>

#include <cmath>
#include <string>

#include <highwall/core/error.h>

namespace highwall {
namespace {

bool IsPositive(double x) {
  return std::isfinite(x) && x > 0.0;
}
bool IsNonNegative(double x) {
  return std::isfinite(x) && x >= 0.0;
}

}  // namespace

const char* ToString(Weighting weighting) {
  return weighting == Weighting::kPaper ? "paper" : "covariance";
}

DepthNoise DepthNoise::Stereo(double subpixel, double focal, double baseline) {
  HIGHWALL_REQUIRE(IsPositive(subpixel),
                   "DepthNoise::Stereo: subpixel must be positive, is " + std::to_string(subpixel));
  HIGHWALL_REQUIRE(IsPositive(focal),
                   "DepthNoise::Stereo: focal must be positive, is " + std::to_string(focal));
  HIGHWALL_REQUIRE(IsPositive(baseline),
                   "DepthNoise::Stereo: baseline must be positive, is " + std::to_string(baseline));
  return {.offset = 0.0, .quadratic = subpixel / (focal * baseline), .reference = 0.0};
}

void DepthNoise::Validate() const {
  HIGHWALL_REQUIRE(IsNonNegative(offset),
                   "DepthNoise::offset must not be negative, is " + std::to_string(offset));
  HIGHWALL_REQUIRE(IsNonNegative(quadratic),
                   "DepthNoise::quadratic must not be negative, is " + std::to_string(quadratic));
  HIGHWALL_REQUIRE(IsNonNegative(reference),
                   "DepthNoise::reference must not be negative, is " + std::to_string(reference));
  HIGHWALL_REQUIRE(offset + quadratic > 0.0,
                   "DepthNoise::offset and quadratic must not both be zero");
  HIGHWALL_REQUIRE(offset > 0.0 || reference == 0.0,
                   "DepthNoise::offset must be positive where reference is: a depth of " +
                       std::to_string(reference) + " m would have no noise");
}

Eigen::Matrix3d PointSqrtInformation(Weighting weighting, double sigma_px, double sigma_disparity) {
  HIGHWALL_REQUIRE(IsPositive(sigma_px), "PointSqrtInformation: sigma_px must be positive, is " +
                                             std::to_string(sigma_px));
  HIGHWALL_REQUIRE(IsPositive(sigma_disparity),
                   "PointSqrtInformation: sigma_disparity must be positive, is " +
                       std::to_string(sigma_disparity));
  Eigen::Matrix3d W = Eigen::Matrix3d::Identity() / sigma_px;
  if (weighting == Weighting::kPaper) {
    W.row(2) = Eigen::RowVector3d(1.0, 0.0, -1.0) / sigma_px;  // Eq. 4
  } else {
    W(2, 2) = 1.0 / sigma_disparity;  // Eq. 3
  }
  return W;
}

}  // namespace highwall
