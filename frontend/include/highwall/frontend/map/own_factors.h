#pragma once

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/frontend/map/map_ids.h>

namespace ceres {
class CostFunction;
class LossFunction;
}  // namespace ceres

// Factors of your own on the poses of the body: docs/own_factors.md.
namespace [[gnu::visibility("default")]] highwall {

// A frame F that your own measurements are taken in: of a GPS, a building, a marker. Where it lies
// is unknown, and estimated.
struct ReferenceFrame {
  bool upright = true;  // its z axis points up
};

// A measurement of your own, of the body at one stamp or several. The system shares the cost: it is
// evaluated on any thread, on several at once.
struct PoseFactor {
  std::vector<Stamp> stamps;  // [ns] ascending, each once; at least one
  // kNoId: of W itself where there is one stamp (of the first submap then), of the motion between
  // them where there are several.
  ReferenceFrameId frame = kNoId;
  // Its blocks are T_WB (7, PoseManifold) of each stamp, then T_FW (7, PoseManifold) where there is
  // a frame.
  std::shared_ptr<ceres::CostFunction> cost;
  std::shared_ptr<ceres::LossFunction> loss{};  // may be null

  // Throws InvalidArgument where the stamps or the blocks are not as above.
  void Validate() const;
};

// A pose of the body that hangs on a keyframe.
struct CarriedPose {
  KeyFrameId keyframe = kNoId;
  Pose T_KB;  // of the body, in the camera of the keyframe
};

// A PoseFactor in a map.
struct MapFactor {
  std::vector<CarriedPose> poses;  // by stamp; of live keyframes of one world
  ReferenceFrameId frame = kNoId;
  std::shared_ptr<ceres::CostFunction> cost;
  std::shared_ptr<ceres::LossFunction> loss;
};

// The factors of a map, and the frames that they are measured in.
class OwnFactors {
 public:
  ReferenceFrameId AddFrame(const ReferenceFrame& frame);
  void Add(MapFactor factor) { factors_.push_back(std::move(factor)); }

  const std::vector<MapFactor>& all() const { return factors_; }
  // Throws InvalidArgument where there is no such frame, as do the next two.
  const ReferenceFrame& frame(ReferenceFrameId id) const;
  // T_FW in the world of a root; empty as long as it is not known.
  std::optional<Pose> T_FW(ReferenceFrameId id, SubmapId root) const;
  void Place(ReferenceFrameId id, SubmapId root, const Pose& T_FW);
  // Of all frames that are known there.
  std::map<ReferenceFrameId, Pose> PlacesIn(SubmapId root) const;
  std::vector<ReferenceFrameId> frames() const;

  // What becomes of the map. A keyframe goes, and what it carries hangs on another one.
  void Carry(KeyFrameId from, KeyFrameId to, const Pose& T_to_from);
  // A keyframe goes, and with it all that it takes part in.
  void Remove(KeyFrameId keyframe);
  // The world of a root has moved: p_new = T_new_old p_old.
  void Transform(SubmapId root, const Pose& T_new_old);
  // A world goes on as another one's; where only one of them knew a frame, that holds.
  void Join(SubmapId root, SubmapId other);

 private:
  struct Frame {
    ReferenceFrame frame;
    std::map<SubmapId, Pose> T_FW;  // by root
  };

  const Frame& At(ReferenceFrameId id) const;

  std::vector<MapFactor> factors_;
  std::vector<Frame> frames_;  // by id
};

}  // namespace highwall
