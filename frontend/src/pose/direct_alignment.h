#pragma once

#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/pose.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/pose/options.h>

#include "features/depth_grid.h"
#include "pose/known_pose.h"

namespace highwall {

struct DirectAlignment {
  KnownPose pose;
  double depth = 0.0;  // [m] median of the frame's
};

// The pose of a camera against one view of the same place, from all of both images on the coarse
// grid: readings of depth against the flat patches of the reference (point to plane), and grey
// levels against its own, up to a gain and an offset. Needs no corner, and blur takes little of it.
// Coarse to fine, by Levenberg-Marquardt with robust weights (Kerl, Sturm, Cremers, "Robust
// odometry estimation for RGB-D cameras", ICRA 2013; Chen, Medioni 1992 for the planes).
class DirectAligner {
 public:
  // grid: of all images; must outlive this.
  DirectAligner(const DepthGrid& grid, const DepthNoise& noise,
                const SurfaceMatcherOptions& surfaces, const DirectAlignmentOptions& options);

  // standing: the depth grid of the reference, 0 where something moved, which is left out. T_WC:
  // rough. The pose with its information, in which readings that share their noise count as
  // one. Empty where the two have too little in common, where what they have in common is not
  // alike, where it does not settle, or where it leaves a direction open.
  std::optional<DirectAlignment> Align(const FrameFeatures& reference, const cv::Mat& standing,
                                       const Pose& T_WR, const FrameFeatures& features,
                                       const Pose& T_WC) const;

 private:
  const DepthGrid& grid_;
  DepthNoise noise_;
  SurfaceMatcherOptions surfaces_;
  DirectAlignmentOptions options_;
};

}  // namespace highwall
