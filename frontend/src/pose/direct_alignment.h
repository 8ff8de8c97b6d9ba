#pragma once

#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/pose.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/pose/pose_constraint.h>

#include "features/depth_grid.h"

namespace highwall {

// Minimum correlation of the grey levels of two images.
inline constexpr double kMinGreyCorrelation = 0.8;

struct DirectAlignment {
  PoseConstraint pose;
  double depth = 0.0;  // [m] median of the frame's
};

// Direct alignment: estimates the pose of a camera against one view of the same place, from both
// whole images on the coarse grid: point-to-plane residuals of depth readings against the planar
// patches of the reference, and photometric residuals up to a gain and an offset. Needs no corners,
// and is robust to blur. Coarse to fine, by Levenberg-Marquardt with robust weights (Kerl, Sturm,
// Cremers, "Robust odometry estimation for RGB-D cameras", ICRA 2013; Chen, Medioni 1992 for the
// planes).
class DirectAligner {
 public:
  // grid: of all images; must outlive this.
  DirectAligner(const DepthGrid& grid, const DepthNoise& noise,
                double min_correlation = kMinGreyCorrelation);

  // standing: the depth grid of the reference, 0 on dynamic objects, which are masked out. T_WC:
  // rough pose. Returns the pose with its information, in which readings with common noise count as
  // one. Empty if the overlap is too small, the overlapping parts are not similar, the iteration
  // does not converge, or a direction is unobservable.
  std::optional<DirectAlignment> Align(const FrameFeatures& reference, const cv::Mat& standing,
                                       const Pose& T_WR, const FrameFeatures& features,
                                       const Pose& T_WC) const;

 private:
  const DepthGrid& grid_;
  DepthNoise noise_;
  double min_correlation_;
};

}  // namespace highwall
