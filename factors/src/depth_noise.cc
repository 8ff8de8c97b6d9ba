#include <highwall/factors/depth_noise.h>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/require.h>

namespace highwall {

const char* ToString(Weighting weighting) {
  return weighting == Weighting::kPaper ? "paper" : "covariance";
}

DepthNoise DepthNoise::Stereo(double subpixel, double focal, double baseline) {
  RequirePositiveFinite(subpixel, "DepthNoise::Stereo: subpixel");
  RequirePositiveFinite(focal, "DepthNoise::Stereo: focal");
  RequirePositiveFinite(baseline, "DepthNoise::Stereo: baseline");
  return {.offset = 0.0, .quadratic = subpixel / (focal * baseline), .reference = 0.0};
}

void DepthNoise::Validate() const {
  RequireNotNegativeFinite(offset, "DepthNoise::offset");
  RequireNotNegativeFinite(quadratic, "DepthNoise::quadratic");
  RequireNotNegativeFinite(reference, "DepthNoise::reference");
  HIGHWALL_REQUIRE(offset + quadratic > 0.0,
                   "DepthNoise::offset and quadratic must not both be zero");
  HIGHWALL_REQUIRE(offset > 0.0 || reference == 0.0,
                   "DepthNoise::offset must be positive where reference is: a depth of " +
                       FixedText(reference) + " m would have no noise");
}

Eigen::Matrix3d PointSqrtInformation(Weighting weighting, double sigma_px, double sigma_disparity) {
  RequirePositiveFinite(sigma_px, "PointSqrtInformation: sigma_px");
  RequirePositiveFinite(sigma_disparity, "PointSqrtInformation: sigma_disparity");
  Eigen::Matrix3d W = Eigen::Matrix3d::Identity() / sigma_px;
  if (weighting == Weighting::kPaper) {
    W.row(2) = Eigen::RowVector3d(1.0, 0.0, -1.0) / sigma_px;  // Eq. 4
  } else {
    W(2, 2) = 1.0 / sigma_disparity;  // Eq. 3
  }
  return W;
}

}  // namespace highwall
