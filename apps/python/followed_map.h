#pragma once

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <highwall/frontend/system/slam_system.h>
#include <highwall/mapping/dense_mapper.h>

#include "exclusive.h"

namespace highwall::python {

// Dense mapper that is fed manually, or follows a system as in `highwall slam`: it maps keyframes
// with corrected depth and without dynamic objects, each world in a separate layer.
class FollowedMap {
 public:
  // Creates a manually fed mapper.
  FollowedMap(const DenseMapOptions& options, const DepthCamera& camera)
      : mapper_(options, camera) {}
  // wait: [s] as for SettlingKeyframes. system: the Python object of slam.
  FollowedMap(const DenseMapOptions& options, const DepthCamera& camera, const SlamSystem& slam,
              double wait, std::shared_ptr<Reference> system);
  FollowedMap(const FollowedMap&) = delete;  // delayed keyframes refer to this
  FollowedMap& operator=(const FollowedMap&) = delete;

  DenseMapper& mapper() { return mapper_; }
  // Returns null if it is fed manually.
  const std::shared_ptr<Reference>& system() const { return system_; }

  // Callbacks as in SlamCallbacks; a frame's keyframe precedes the frame. original: the image given
  // to Track().
  void SetKeyframe(const SlamSystem& slam, const KeyFrame& keyframe, const RgbdImage& image,
                   const RgbdImage& original);
  void Follow(const SlamSystem& slam, const FrameResult& frame);
  // Returns the map of each layer, in the order of submaps() of a followed system. slam: null if
  // there is none. Call once, last.
  std::vector<DenseMap> Finish(const SlamSystem* slam);

 private:
  struct Original {
    RgbdImage image;
    DepthPattern known;  // applied to its depth
  };

  void Settle(const cv::Mat& moving);
  // Maps keyframes again that were created with an older estimate of the depth distortion.
  void MapAgain(const SlamSystem& slam);

  DenseMapper mapper_;
  std::shared_ptr<Reference> system_;
  std::optional<SettlingKeyframes> settling_;
  std::optional<KeyframeImage> keyframe_;  // of the next frame
  std::map<KeyFrameId, Original> originals_;
  bool finished_ = false;
};

}  // namespace highwall::python
