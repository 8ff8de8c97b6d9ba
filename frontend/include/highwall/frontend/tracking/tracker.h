#pragma once

#include <optional>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/frontend/tracking/constant_velocity.h>
#include <highwall/frontend/pose/degeneracy.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_matcher.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/tracking/moving_objects.h>
#include <highwall/frontend/pose/pose_solver.h>
#include <highwall/frontend/tracking/relocalizer.h>
#include <highwall/frontend/pose/surface_matcher.h>

namespace highwall {

enum class TrackingState {
  kInitializing,  // no map yet: the first frames had too little depth or texture
  kTracking,
  kInertial,  // the pose is that of the IMU alone: the image shows nothing that is known
  kLost,      // no pose for this frame; the map is kept and every new frame tries to relocalize
};

// "initializing", "tracking", "inertial" or "lost".
const char* ToString(TrackingState state);
// The frame has a pose: kTracking and kInertial.
bool HasPose(TrackingState state);

// How surfaces hold a pose that points and lines alone do not: points of the image lie on the flat
// patches that the reference keyframe saw. Without an IMU, which bridges such frames by itself.
struct SurfaceTrackingOptions {
  bool enabled = true;
  SurfaceMatcherOptions matcher{};
  int min_support = 6;     // >= 3, of points and lines (PoseSolverOptions)
  int min_rows = 30;       // >= 1, on patches
  double max_sigma = 0.2;  // [m] > 0: a pose with a more open direction is none

  void Validate() const;
};

struct TrackerOptions {
  PoseSolverOptions pose{};
  MapMatcherOptions matcher{};
  RelocalizerOptions relocalizer{};
  MovingObjectOptions moving{};
  DegeneracyOptions degeneracy{};
  SurfaceTrackingOptions surfaces{};
  // Support (PoseSolverOptions) for a pose to be believed, >= 6: after the first match against the
  // last frame or keyframe, and after the local map.
  int min_motion_support = 15;
  int min_support = 25;
  // The same for both where the pose is predicted by an IMU, which tells wrong matches, >= 6.
  int min_predicted_support = 12;
  // A pose may be a coincidence of repeated patterns, on which a few agree and most deny it, where
  // its support is less than the first share of that of all first matches, less than the second of
  // the landmarks of the local map in view, or less than the third of the last frame's support, all
  // in [0, 1]: what the descriptors of the reference keyframe say is tried as well, and the better
  // supported pose is kept. Where most first matches deny it, it must leave no direction open.
  double doubtful_agreement = 0.33;
  double doubtful_share = 0.06;
  double doubtful_drop = 0.3;
  int local_keyframes = 24;  // >= 1: most keyframes whose landmarks are searched

  void Validate() const;
};

// A frame with its pose and the landmarks its features were found to be.
struct TrackedFrame {
  Frame frame;
  TrackingState state = TrackingState::kLost;
  bool relocalized = false;      // found again in this frame
  Pose T_WC;                     // meaningful where HasPose(state)
  KeyFrameId reference = kNoId;  // the keyframe that shares most landmarks
  std::vector<PointId> points;   // per point feature, kNoId where unmatched; inliers only
  std::vector<LineId> lines;     // per line feature
  // The same as they were matched, outliers included.
  std::vector<PointId> tried_points;
  std::vector<LineId> tried_lines;
  // Cells that move (MovingObjects::Find); empty where nothing does. Features there are not among
  // those of `frame`.
  cv::Mat moving;
  int num_points = 0, num_lines = 0;  // matched
  int num_planes = 0;                 // points of the image on flat patches of the reference
  // What the matches alone say of the pose (PoseSolution).
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
  double error = 1.0;
  std::vector<OpenDirection> open;  // directions of the pose that they leave open
};

// Camera pose frame by frame: prediction by an IMU or at constant velocity, matching of the last
// frame's landmarks by projection, pose by SolvePose, then the same with the landmarks of the local
// map. Falls back on descriptor matching with the reference keyframe, then on relocalization. (Xiao
// et al. 2025, figure 2, tracking.)
class Tracker {
 public:
  // levels: of the ORB pyramid. model: must outlive the tracker.
  Tracker(const MeasurementModel& model, int levels, const TrackerOptions& options);

  // predicted: the pose that an IMU tells, where there is one. Also counts in the map how often
  // landmarks were in view and found.
  TrackedFrame Track(const Frame& frame, Map& map,
                     const std::optional<KnownPose>& predicted = std::nullopt);

  // Tells the tracker that `tracked` became the keyframe: its landmarks, new ones included, are
  // the ones the next frame is matched to, from its pose after the adjustment.
  void Anchor(const TrackedFrame& tracked, const KeyFrame& keyframe);
  // The pose of the last frame as it was found in the end.
  void Correct(const Pose& T_WC);
  // The keyframe that the last tracked frame shares most landmarks with; empty when lost.
  std::optional<KeyFrameId> reference() const;
  // The cells of a keyframe that move, as the depth of the seconds before and since tells.
  cv::Mat MovingIn(const KeyFrame& keyframe, const Map& map) const;
  // Follows the map, which has moved about here: p_new = T_new_old p_old.
  void Transform(const Pose& T_new_old);

 private:
  // What may tell a pose, beside points and lines.
  enum class Aid { kNone, kSurfaces };

  // [s] from the last frame tracked to `frame`.
  double SinceLast(const Frame& frame) const;
  std::optional<TrackedFrame> TrackMotion(const Frame& frame, const Map& map,
                                          const KnownPose* predicted, Aid aid = Aid::kNone) const;
  std::optional<TrackedFrame> TrackReference(const Frame& frame, const Map& map) const;
  std::optional<TrackedFrame> Relocalize(const Frame& frame, const Map& map) const;
  // A frame matched with the local map, and the landmarks that were to be seen from its pose.
  struct LocalMatch {
    TrackedFrame frame;
    std::vector<PointId> points_in_view;
    std::vector<LineId> lines_in_view;

    int Support() const;
    void CountSightings(Map& map) const;
  };
  // Adds what the local map holds to a frame with a rough pose; empty where too little fits.
  std::optional<LocalMatch> TrackLocalMap(std::optional<TrackedFrame> rough, const Map& map,
                                          const KnownPose* predicted = nullptr,
                                          Aid aid = Aid::kNone) const;
  // Whether the landmarks on a surface of the depth grid contradict all others but those on
  // `moving`.
  bool HasMoved(const TrackedFrame& rough, const Map& map, const DepthSurfaces& surfaces,
                int surface, const cv::Mat& moving) const;
  // Takes the features off a frame that are on something that moves.
  void SetMovingAside(TrackedFrame& rough, const Map& map) const;
  // Few of the first matches agree with their pose.
  bool IsDenied(const TrackedFrame& rough) const;
  bool IsDoubtful(const LocalMatch& match) const;
  // Pose from the matches of `tracked`; outliers are unmatched. False where too few remain.
  bool Solve(TrackedFrame& tracked, const Map& map, int min_support, const KnownPose* predicted,
             Aid aid) const;

  // Rows on the flat patches that the reference keyframe of the last frame saw; none where it has
  // no depth.
  std::vector<PointToPlaneRow> MatchSurfaces(const TrackedFrame& tracked, const Map& map) const;

  const MeasurementModel& model_;
  TrackerOptions options_;
  MapMatcher matcher_;
  Relocalizer relocalizer_;
  MovingObjects moving_;
  std::optional<TrackedFrame> last_;  // the last frame tracked
  int last_support_ = 0;              // of its pose
  ConstantVelocity velocity_;         // at it
};

}  // namespace highwall
