#pragma once

#include <memory>

#include <highwall/core/camera.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/map.h>

#include "features/depth_grid.h"
#include "local/corner_patch.h"
#include "tracking/tracked_frame.h"

namespace highwall {

// Refines detected corners, whose positions have errors from the detector's pyramid and from noise,
// by aligning the first observed patch of their landmark with the image of a keyframe.
class CornerRefiner {
 public:
  // camera: must outlive it.
  explicit CornerRefiner(const PinholeCamera& camera) : camera_(camera), grid_(camera) {}

  // Returns the features of a frame that becomes a keyframe, without the image. Those of landmarks
  // with a patch are moved to the aligned position, with the noise of refined corners.
  std::shared_ptr<const FrameFeatures> Refine(const TrackedFrame& tracked, const ImageLevels& image,
                                              const Map& map) const;
  // Stores patches of the image in those landmarks of the keyframe that have none yet, if the patch
  // shows a single surface.
  void Remember(const KeyFrame& keyframe, const ImageLevels& image, Map* map) const;

 private:
  // Returns whether no depth reading within the patch of the corner [px] belongs to a surface in
  // front of or behind that at z [m].
  bool LiesOnOneSurface(const cv::Mat& depth_grid, const Eigen::Vector2d& uv, double radius,
                        double z) const;

  const PinholeCamera& camera_;
  DepthGrid grid_;
};

}  // namespace highwall
