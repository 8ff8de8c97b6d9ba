#pragma once

#include <Eigen/Core>

namespace [[gnu::visibility("default")]] highwall {

// By how much the inverse of a reading of depth is too large over the image, beside what it is
// everywhere: nodes on a coarse grid whose outer ones lie on the image's outer pixels, bilinear
// between them.                                                  docs/factors/depth_pattern.md
//
//   1/reading = 1/z + o + w(u, v)^T nodes                                                   Eq. 1
//
// Source: Herrera C., Kannala, Heikkila, "Joint depth and color camera calibration with distortion
// correction", PAMI 34(10), 2012, section 2.3, whose disparities have a pattern over the image;
// there a value for each pixel.
struct DepthPattern {
  static constexpr int kColumns = 5, kRows = 4, kNodes = kColumns * kRows;
  using Vector = Eigen::Matrix<double, kNodes, 1>;

  Vector nodes = Vector::Zero();  // [1/m] row by row

  // Throws InvalidArgument naming the field unless all are within 1.
  void Validate() const;

  bool IsZero() const { return nodes.isZero(0.0); }
  // [1/m] The root mean square of the nodes.
  double Rms() const;
  // [1/m] at a pixel; beyond the image as at its edge. width, height: of the image [px], positive.
  double At(double u, double v, int width, int height) const;
  // The share w of each node in that, 1 in sum.
  static Vector Shares(double u, double v, int width, int height);
};

}  // namespace highwall
