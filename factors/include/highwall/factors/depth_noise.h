#pragma once

#include <Eigen/Core>

#include <highwall/core/camera.h>

namespace [[gnu::visibility("default")]] highwall {

// Whitening of the residual rows that carry depth (docs/factors/depth_noise.md).
enum class Weighting {
  kCovariance,  // by the first-order covariance of pixel and depth noise
  kPaper,  // rows of the virtual right image, one sigma for all (Xiao et al. 2025, section 3.3)
};

// Returns "covariance" or "paper".
const char* ToString(Weighting weighting);

// Standard deviation of a measured depth d [m]:
//   sigma_d(d) = offset + quadratic (d - reference)^2           docs/factors/depth_noise.md, Eq. 1
// The default is Kinect().
struct DepthNoise {
  double offset = 0.0012;     // [m] >= 0; positive unless reference is zero
  double quadratic = 0.0019;  // [1/m] >= 0; offset and quadratic must not both be zero
  double reference = 0.4;     // [m] >= 0

  // Axial noise of the structured-light Kinect. Source: Nguyen, Izadi, Lovell, "Modeling Kinect
  // sensor noise for improved 3D reconstruction and tracking", 3DIMPVT 2012; the axial model holds
  // for surfaces tilted by up to 60 degrees.
  static DepthNoise Kinect() { return {}; }
  // Stereo triangulation: sigma_d = subpixel d^2 / (focal baseline). subpixel: standard deviation
  // of a matched disparity [px]; focal [px] and baseline [m] are those of the sensor's stereo pair.
  // The default is a RealSense D435i at 848 x 480. Throws InvalidArgument unless all are positive.
  static DepthNoise Stereo(double subpixel = 0.08, double focal = 425.0, double baseline = 0.05);

  // Throws InvalidArgument naming the field.
  void Validate() const;

  // Returns sigma_d [m] at depth d [m] > 0.
  double Sigma(double d) const {
    return offset + quadratic * (d - reference) * (d - reference);  // Eq. 1
  }
  // Returns the standard deviation of the virtual disparity delta = fx b / d [px], to first order.
  double DisparitySigma(double d, const VirtualRightCamera& right) const {
    return right.fx * right.baseline / (d * d) * Sigma(d);  // Eq. 2
  }
};

// Returns the square-root information of the point row (u, v, delta): W^T W = Sigma^-1.
//   kCovariance  W = diag(1/sigma_px, 1/sigma_px, 1/sigma_disparity)                         Eq. 3
//   kPaper       W (u, v, delta) = (u, v, u_R) / sigma_px; sigma_disparity is not used       Eq. 4
// sigma_px: standard deviation of u and of v [px]; sigma_disparity: DepthNoise::DisparitySigma
// [px]. Throws InvalidArgument unless both are positive and finite.
Eigen::Matrix3d PointSqrtInformation(Weighting weighting, double sigma_px, double sigma_disparity);

}  // namespace highwall
