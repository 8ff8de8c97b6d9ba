#pragma once

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <highwall/frontend/system/slam_system.h>
#include <highwall/mapping/dense_mapper.h>

#include "exclusive.h"

namespace highwall::python {

// A dense mapper that is fed by hand, or follows a system as `highwall slam` has it: keyframes with
// their corrected depth, without what moves, each world in a layer of its own.
class FollowedMap {
 public:
  // Fed by hand.
  FollowedMap(const DenseMapOptions& options, const DepthCamera& camera)
      : mapper_(options, camera) {}
  // wait: [s] as of SettlingKeyframes. system: the Python object of slam.
  FollowedMap(const DenseMapOptions& options, const DepthCamera& camera, const SlamSystem& slam,
              double wait, std::shared_ptr<Reference> system);
  FollowedMap(const FollowedMap&) = delete;  // what settles refers to this
  FollowedMap& operator=(const FollowedMap&) = delete;

  DenseMapper& mapper() { return mapper_; }
  // Null where it is fed by hand.
  const std::shared_ptr<Reference>& system() const { return system_; }

  // What SlamCallbacks say; a frame's keyframe comes before the frame. original: the image as it
  // was given to Track().
  void SetKeyframe(const SlamSystem& slam, const KeyFrame& keyframe, const RgbdImage& image,
                   const RgbdImage& original);
  void Follow(const SlamSystem& slam, const FrameResult& frame);
  // The map of each layer; of a system that is followed in the order of its submaps(). slam: null
  // where there is none. Call once, last.
  std::vector<DenseMap> Finish(const SlamSystem* slam);

 private:
  struct Original {
    RgbdImage image;
    DepthPattern known;  // when its depth was corrected
  };

  void Settle(const cv::Mat& moving);
  // Keyframes that were made before the pattern of their depth was known as it is now.
  void MapAgain(const SlamSystem& slam);

  DenseMapper mapper_;
  std::shared_ptr<Reference> system_;
  std::optional<SettlingKeyframes> settling_;
  std::optional<KeyframeImage> keyframe_;  // of the frame that is to come
  std::map<KeyFrameId, Original> originals_;
  bool finished_ = false;
};

}  // namespace highwall::python
