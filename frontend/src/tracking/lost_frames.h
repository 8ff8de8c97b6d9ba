#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <highwall/core/camera.h>
#include <highwall/core/stamp.h>
#include <highwall/frontend/features/twist.h>
#include <highwall/frontend/map/anchored_pose.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/tracking/options.h>

#include "features/depth_grid.h"
#include "map/map_matcher.h"
#include "tracking/frame_refiner.h"
#include "tracking/lost_frame.h"
#include "tracking/pose_hypothesis.h"
#include "tracking/relocalizer.h"
#include "tracking/tracked_frame.h"
#include "tracking/tracker_parameters.h"

namespace highwall {

class RunProfile;

// Keeps the features of frames without a pose, and searches for their poses at the end, when the
// map holds what came after them: from the pose that the frames before and after imply, by the
// descriptors of their keyframes, and by the index of places. Depth must not contradict a pose, and
// the camera must be able to have come from the frames before and after. A recognized place, and
// where these frames are of another world or far away, must match as much of the map as tracking
// demands of a recognized place. (docs/tracking.md)
class LostFrames {
 public:
  // model: must outlive this. camera: with its distortion. most: frames kept, those added last.
  // profile (null: none): must outlive this.
  LostFrames(const MeasurementModel& model, const PinholeCamera& camera,
             const TrackerOptions& options, std::size_t most,
             const TrackerParameters& parameters = {}, RunProfile* profile = nullptr);

  // Adds a frame, in any order. Frames without features are ignored.
  void Add(LostFrame lost);
  // Searches for all of them, and forgets them. frames: those with a pose, ascending by stamp.
  // usual_match_ratio: for frames from before it was known. Returns those that were found,
  // ascending by stamp.
  std::vector<PosedFrame> Find(const Map& map, const ImageKnowledge& knowledge,
                               std::span<const PosedFrame> frames, double usual_match_ratio);
  // Of their features.
  std::size_t MemoryBytes() const;

 private:
  // A pose of a frame before or after a lost one.
  struct Neighbour {
    Stamp stamp = 0;
    Pose T_WC;
    KeyFrameId reference = kNoId;  // active
    SubmapId root = kFirstSubmap;
  };
  struct Neighbours {
    std::optional<Neighbour> before{}, after{};
    // Returns the mean motion between the two; empty if they are of different worlds or too far
    // apart in time.
    std::optional<Twist> Motion() const;
  };
  // Whether the camera can have come to a pose from the frames before and after, or on to them, in
  // the time between: kUnknown where these are of other worlds, or far away in time and space.
  enum class Reach { kReachable, kUnknown, kUnreachable };

  std::optional<PosedFrame> FindOne(const Map& map, const ImageKnowledge& knowledge,
                                    const Neighbours& around, LostFrame lost) const;
  // Returns the frame with a pose by one hypothesis after the other; empty if all are refuted.
  std::optional<TrackedFrame> Search(const Map& map, const Neighbours& around,
                                     const LostFrame& lost) const;
  // Returns the first matches at the pose that the frames before and after imply.
  std::optional<TrackedFrame> Interpolated(const Map& map, const Neighbours& around,
                                           const Frame& frame) const;
  // Matches the landmarks around and re-estimates the pose; empty if it is refuted.
  std::optional<TrackedFrame> Verified(const Map& map, const Neighbours& around,
                                       const LostFrame& lost, TrackedFrame rough,
                                       PoseOrigin origin) const;
  static Reach ReachOf(const Map& map, const Neighbours& around, const TrackedFrame& found);
  // Returns the nearest frames whose poses their images state, not a prediction. stamp: at which
  // the lost frame's image was taken.
  static Neighbours Around(const Map& map, std::span<const PosedFrame> frames, Stamp stamp);

  const MeasurementModel& model_;
  const PinholeCamera camera_;
  const TrackerOptions options_;
  const std::size_t most_;
  const TrackerParameters parameters_;
  RunProfile* const profile_;
  const MapMatcher matcher_;
  const Relocalizer relocalizer_, reference_matcher_;
  const DepthGrid grid_;
  std::vector<LostFrame> lost_;
};

}  // namespace highwall
