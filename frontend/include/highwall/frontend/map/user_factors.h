#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/frontend/map/map_ids.h>

namespace ceres {
class CostFunction;
class LossFunction;
}  // namespace ceres

// User factors on the poses of the body: docs/user_factors.md.
namespace [[gnu::visibility("default")]] highwall {

// Reference frame F of user measurements: of a GPS, a building, a marker. Its pose is unknown, and
// estimated.
struct ReferenceFrame {
  bool upright = true;  // its z axis points up
};

// A user measurement of the body at one stamp or several. The system shares ownership of the cost
// and evaluates it on any thread, on several at the same time.
struct PoseFactor {
  std::vector<Stamp> stamps;  // [ns] ascending, each once; at least one
  // kNoId: with one stamp relative to W itself (of the first submap then), with several stamps a
  // measurement of the relative motion.
  ReferenceFrameId frame = kNoId;
  // Its parameter blocks are T_WB (7, PoseManifold) of each stamp, then T_FW (7, PoseManifold) if
  // there is a frame.
  std::shared_ptr<ceres::CostFunction> cost;
  std::shared_ptr<ceres::LossFunction> loss{};  // may be null
  // Name of the sensor, by which factors are counted (SlamSystem::factor_counts_by_source()).
  std::string source{};

  // Throws InvalidArgument if the stamps or the blocks are not as above.
  void Validate() const;
};

// A pose of the body anchored to a keyframe.
struct AnchoredBodyPose {
  KeyFrameId keyframe = kNoId;
  Pose T_KB;  // body pose in the camera frame of the keyframe
};

// A PoseFactor in a map.
struct MapFactor {
  std::vector<AnchoredBodyPose> poses;  // one per stamp; anchored to active keyframes of one world
  ReferenceFrameId frame = kNoId;
  std::shared_ptr<ceres::CostFunction> cost;
  std::shared_ptr<ceres::LossFunction> loss;
  std::string source{};
  std::int64_t number = 0;  // ascending in the order of UserFactors::Add(), which assigns it
};

// The user factors of a map, and their reference frames.
class UserFactors {
 public:
  ReferenceFrameId AddFrame(const ReferenceFrame& frame);
  // Adds a factor, or drops it if it is a motion within one keyframe: several poses, all of them
  // anchored to one keyframe, and no frame. Its residual is the same wherever the keyframe is.
  void Add(MapFactor factor);

  const std::vector<MapFactor>& all() const { return factors_; }
  // Number of motions within one keyframe that were dropped, by MapFactor::source.
  const std::map<std::string, std::size_t>& dropped() const { return dropped_; }
  // Throws InvalidArgument if there is no such frame, as do the next two.
  const ReferenceFrame& frame(ReferenceFrameId id) const;
  // T_FW in the world of a root; empty as long as it is unknown.
  std::optional<Pose> T_FW(ReferenceFrameId id, SubmapId root) const;
  void Place(ReferenceFrameId id, SubmapId root, const Pose& T_FW);
  // All frames whose pose is known in that world.
  std::map<ReferenceFrameId, Pose> PlacesIn(SubmapId root) const;
  std::vector<ReferenceFrameId> frames() const;

  // Re-anchors the poses of a keyframe that is removed to another one; drops the factors that
  // become motions within one keyframe.
  void Carry(KeyFrameId from, KeyFrameId to, const Pose& T_to_from);
  // Removes all factors that involve a keyframe that is removed.
  void Remove(KeyFrameId keyframe);
  // The world of a root has moved: p_new = T_new_old p_old.
  void Transform(SubmapId root, const Pose& T_new_old);
  // Moves the frames of a merged world to the root; if only one of them knew the pose of a frame,
  // that pose is kept.
  void Join(SubmapId root, SubmapId other);

 private:
  struct Frame {
    ReferenceFrame frame;
    std::map<SubmapId, Pose> T_FW;  // by root
  };

  const Frame& At(ReferenceFrameId id) const;

  std::vector<MapFactor> factors_;
  std::int64_t added_ = 0;  // factors so far
  std::vector<Frame> frames_;  // by id
  std::map<std::string, std::size_t> dropped_;
};

}  // namespace highwall
