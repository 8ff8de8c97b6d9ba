#pragma once

#include <map>
#include <memory>
#include <utility>
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
  // system: the Python object of the system.
  FollowedMap(const DenseMapOptions& options, const DepthCamera& camera,
              std::shared_ptr<Reference> system)
      : mapper_(options, camera), system_(std::move(system)) {}

  DenseMapper& mapper() { return mapper_; }
  // Returns null if it is fed manually.
  const std::shared_ptr<Reference>& system() const { return system_; }

  // Callbacks as in SlamCallbacks. original: the image given to Track().
  void SetKeyframe(const SlamSystem& slam, const KeyFrame& keyframe, const RgbdImage& original);
  void Apply(const KeyframeEvent& event);
  // Returns the map of each layer, in the order of submaps() of a followed system. slam: null if
  // there is none. Call once, last.
  std::vector<DenseMap> Finish(const SlamSystem* slam);

 private:
  struct Original {
    RgbdImage image;
    DepthPattern known;  // applied to its depth
  };

  // Maps keyframes again that were created with an older estimate of the depth distortion.
  void MapAgain(const SlamSystem& slam);

  DenseMapper mapper_;
  std::shared_ptr<Reference> system_;
  std::map<KeyFrameId, Original> originals_;
  bool finished_ = false;
};

}  // namespace highwall::python
