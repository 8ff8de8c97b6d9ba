#include <highwall/frontend/features/depth_correction.h>

#include <highwall/frontend/input/dataset.h>

#include "features/row_times.h"

namespace highwall {

bool DepthCorrection::MovesRows() const {
  const bool stands = motion.v.isZero(0.0) && motion.omega.isZero(0.0);
  return !stands && (timing.depth_delay != 0.0 || timing.depth_readout != timing.colour_readout);
}

bool DepthCorrection::IsIdentity() const {
  return pattern.IsZero() && !MovesRows();
}

cv::Mat DepthCorrection::Apply(const cv::Mat& depth, const PinholeCamera& camera) const {
  const cv::Mat metric = pattern.IsZero() ? depth : MetricDepth(depth, 1.0, 0.0, pattern);
  if (!MovesRows()) return metric;
  return DepthAtTime(metric, camera, motion, timing.depth_delay,
                     timing.depth_readout - timing.colour_readout, timing.direction);
}

}  // namespace highwall
