#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/frontend/map/anchored_pose.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/system/slam_system.h>

namespace highwall {

// User factors waiting for their poses. A factor waits until a frame at or after its last stamp has
// a pose; then the pose of the body at each stamp, interpolated between the frames before and after
// it, is anchored to the keyframe of the nearer one.
class PendingFactors {
 public:
  // T_CB: pose of the body in the camera. max_gap [s]: that of UserFactorOptions.
  PendingFactors(const Pose& T_CB, double max_gap) : T_CB_(T_CB), max_gap_(max_gap) {}

  // Applies to poses determined from now on.
  void SetExtrinsics(const Pose& T_CB) { T_CB_ = T_CB; }
  void Add(PoseFactor factor) { waiting_.push_back(std::move(factor)); }
  // Adds the factors that need not wait any longer to the map. frames: all so far, by stamp.
  void Attach(const std::vector<PosedFrame>& frames, Map* map);

  // A factor is refused if no frame with a pose is near enough, or if the frames are in different
  // worlds. in_map: those of the map, which may drop some of them.
  FactorCounts Counts(const UserFactors& in_map) const;
  // Returns the same by PoseFactor::source.
  std::map<std::string, FactorCounts> BySource(const UserFactors& in_map) const;

 private:
  std::optional<MapFactor> MakeFactor(const PoseFactor& factor,
                                      const std::vector<PosedFrame>& frames, const Map& map) const;
  std::optional<AnchoredBodyPose> PoseAt(Stamp stamp, const std::vector<PosedFrame>& frames,
                                         const Map& map) const;

  Pose T_CB_;
  const double max_gap_;
  std::vector<PoseFactor> waiting_;
  std::map<std::string, FactorCounts> of_source_;  // without those that wait
};

}  // namespace highwall
