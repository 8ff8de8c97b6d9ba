#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/frontend/map/anchored_pose.h>
#include <highwall/frontend/map/map.h>

namespace highwall {

// Factors of the user's on their way into the map. One waits until a frame at its last stamp, or
// after it, has a pose; then the pose of the body at each stamp, between the frames before and
// after it, hangs on the keyframe of the nearer one.
class PendingFactors {
 public:
  // T_CB: of the body in the camera. max_gap [s]: OwnFactorOptions.
  PendingFactors(const Pose& T_CB, double max_gap) : T_CB_(T_CB), max_gap_(max_gap) {}

  // Of poses from now on.
  void SetExtrinsics(const Pose& T_CB) { T_CB_ = T_CB; }
  void Add(PoseFactor factor) { waiting_.push_back(std::move(factor)); }
  // Hands on to the map what no longer waits. frames: all so far, by stamp.
  void Attach(const std::vector<PosedFrame>& frames, Map* map);

  std::size_t waiting() const { return waiting_.size(); }
  std::size_t attached() const { return attached_; }
  // No frame with a pose was near enough, or the frames were in different worlds.
  std::size_t refused() const { return refused_; }

 private:
  std::optional<MapFactor> MakeFactor(const PoseFactor& factor,
                                      const std::vector<PosedFrame>& frames, const Map& map) const;
  std::optional<CarriedPose> PoseAt(Stamp stamp, const std::vector<PosedFrame>& frames,
                                    const Map& map) const;

  Pose T_CB_;
  const double max_gap_;
  std::vector<PoseFactor> waiting_;
  std::size_t attached_ = 0, refused_ = 0;
};

}  // namespace highwall
