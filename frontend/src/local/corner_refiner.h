#pragma once

#include <memory>

#include <highwall/core/camera.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/map.h>

#include "features/depth_grid.h"
#include "local/corner_patch.h"
#include "tracking/tracked_frame.h"

namespace highwall {

// Corners that a detector finds again are off by what its pyramid and the noise leave. Where a
// landmark is, a keyframe tells by what it looked like first: its patch there is laid over the
// image.
class CornerRefiner {
 public:
  // camera: must outlive it.
  explicit CornerRefiner(const PinholeCamera& camera) : camera_(camera), grid_(camera) {}

  // The features of a frame that becomes a keyframe, those of landmarks with a patch moved to where
  // it fits, with the noise of refined corners; without the image.
  std::shared_ptr<const FrameFeatures> Refine(const TrackedFrame& tracked, const ImageLevels& image,
                                              const Map& map) const;
  // Landmarks of the keyframe that have no patch yet take theirs of its image, where that is of one
  // surface.
  void Remember(const KeyFrame& keyframe, const ImageLevels& image, Map* map) const;

 private:
  // No reading of the depth within the patch of the corner [px] is of a surface before or behind
  // that at z [m].
  bool LiesOnOneSurface(const cv::Mat& depth_grid, const Eigen::Vector2d& uv, double radius,
                        double z) const;

  const PinholeCamera& camera_;
  DepthGrid grid_;
};

}  // namespace highwall
