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
// Minimum number of readings on planar patches.
inline constexpr int kMinPlaneReadings = 30;

// Where an alignment begins.
enum class AlignmentStart {
  kPredicted,  // at a predicted pose: the coarsest stage finds the motion
  kAligned,    // at the pose of an alignment of much the same images: without the coarsest stage
};

struct DirectAlignment {
  PoseConstraint pose;
  double depth = 0.0;        // [m] median of the frame's
  double correlation = 0.0;  // of the grey levels
  // Mean squares of the residuals, outliers with less weight: of readings on patches [sigma^2] and
  // of grey levels [grey levels^2].
  double plane_error = 0.0, grey_error = 0.0;
  int planes = 0;        // readings on patches
  double overlap = 0.0;  // share of the frame's depth that the reference sees
};

// Direct alignment: estimates the pose of a camera against one view of the same place, from both
// whole images on the coarse grid: point-to-plane residuals of depth readings against the planar
// patches of the reference, and photometric residuals up to a gain and an offset. Needs no corners,
// and is robust to blur. Coarse to fine, by Levenberg-Marquardt with robust weights (Kerl, Sturm,
// Cremers, "Robust odometry estimation for RGB-D cameras", ICRA 2013; Chen, Medioni 1992 for the
// planes).
class DirectAligner {
 public:
  // grid: of all images; must outlive this. enough: norm [m, rad] of a step that ends a stage, if
  // it is coarser than the stage's own.
  DirectAligner(const DepthGrid& grid, const DepthNoise& noise,
                double min_correlation = kMinGreyCorrelation, int min_planes = kMinPlaneReadings,
                double enough = 0.0);

  // standing: the depth grid of the reference, 0 on dynamic objects, which are masked out. T_WC:
  // rough pose. Returns the pose with its information, in which readings with common noise count as
  // one; grey levels have it where the views overlap by less than two thirds. Empty if the overlap
  // is too small, the overlapping parts are not similar, the iteration does not converge, or a
  // direction is unobservable.
  std::optional<DirectAlignment> Align(const FrameFeatures& reference, const cv::Mat& standing,
                                       const Pose& T_WR, const FrameFeatures& features,
                                       const Pose& T_WC,
                                       AlignmentStart start = AlignmentStart::kPredicted) const;

 private:
  const DepthGrid& grid_;
  DepthNoise noise_;
  double min_correlation_;
  int min_planes_;
  double enough_;
};

}  // namespace highwall
