#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <highwall/frontend/local/bundle_adjustment.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_matcher.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/tracking/tracker.h>

namespace highwall {

struct LocalMapperOptions {
  BundleAdjustmentOptions bundle{.threads = 1};  // tracking takes the others
  MapMatcherOptions matcher{};                   // for the fusion of landmarks
  int adjusted_keyframes = 12;                   // >= 2: most keyframes moved by a local adjustment
  int fixed_keyframes = 20;                      // >= 1: most keyframes that hold it in place
  int fused_keyframes = 8;  // >= 0: neighbours whose landmarks are looked for in a new keyframe
  // A landmark is dropped when found in fewer of the frames that had it in view, or when, this
  // many keyframes after its creation, fewer keyframes see it; also where the removal of a keyframe
  // leaves fewer.
  double min_found_ratio = 0.25;  // [0, 1]
  int probation_keyframes = 3;    // >= 1
  int min_observations = 2;       // >= 1
  // A keyframe is dropped when this share of its points, or of its lines where it has no points, is
  // seen by so many others, points at levels up to one coarser, lines by twice as many,
  // for they are found less often. This bounds the map by the area that it covers, however long the
  // camera stays.
  double redundant_share = 0.9;  // (0, 1]; 1 keeps all but exact repeats
  int redundant_observers = 2;   // >= 1
  // With an IMU a keyframe of the last motion_span is kept where its neighbours in time would be
  // left farther apart than this, for the IMU ties them the better the nearer they are. An older
  // one goes, and the tie with it.
  double max_motion_gap = 1.0;    // [s] > 0
  double motion_span = 20.0;      // [s] >= 0
  double max_depth_sigma = 0.03;  // > 0, of its depth: a corner known worse makes no landmark
  double min_line_length = 0.05;  // [m] > 0: shorter segments make no landmark
  // The local adjustment runs on a thread of its own and is applied between frames. false: before
  // InsertKeyFrame returns; the same input then gives the same map.
  bool background = true;
  // For an adjustment that still runs when the next keyframe comes. false: it ends after the
  // running iteration, for a camera that does not wait.
  bool wait = true;

  void Validate() const;
};

struct LocalMappingReport {
  KeyFrameId keyframe = kNoId;
  BundleAdjustmentReport bundle;  // in the background: what Update() returns instead
  int new_points = 0, new_lines = 0, fused_points = 0;
  int culled_points = 0, culled_lines = 0;
  std::vector<KeyFrameId> culled_keyframes;
};

// Grows and cleans the map, a keyframe at a time: landmarks from depth, fusion with those of
// neighbouring keyframes, culling, local bundle adjustment. (Xiao et al. 2025, figure 2, local
// mapping.)
class LocalMapper {
 public:
  // levels: of the ORB pyramid. model: must outlive the mapper.
  LocalMapper(const MeasurementModel& model, int levels, const LocalMapperOptions& options);
  // An adjustment that still runs is given up.
  ~LocalMapper();
  LocalMapper(const LocalMapper&) = delete;
  LocalMapper& operator=(const LocalMapper&) = delete;

  // First applies the adjustment of the keyframe before, where Finish() has not. motion: of the
  // body, where an IMU tells it.
  LocalMappingReport InsertKeyFrame(const TrackedFrame& tracked, Map& map,
                                    std::optional<KeyFrameMotion> motion = std::nullopt);

  // An adjustment is done and waits to be applied.
  bool HasNews() const;
  // Applies to the map the adjustment that is done, or, in Finish(), that is waited for; between
  // frames. Empty where there is none.
  std::optional<BundleAdjustmentReport> Update(Map* map);
  std::optional<BundleAdjustmentReport> Finish(Map* map);
  // Ends the adjustment that runs; nothing of it is applied: of a map that moves meanwhile.
  void GiveUp();

 private:
  class Adjustment;
  struct Landmarks {
    std::vector<PointId> points;
    std::vector<LineId> lines;
  };

  void CreatePoints(KeyFrame& keyframe, Map& map, LocalMappingReport& report);
  void CreateLines(KeyFrame& keyframe, Map& map, LocalMappingReport& report);
  // Finds the landmarks of neighbouring keyframes that this one sees without having been tracked
  // to them.
  void FuseNeighbours(KeyFrameId id, Map& map, LocalMappingReport& report) const;
  void FusePoints(KeyFrameId id, std::span<const KeyFrameId> neighbours, Map& map,
                  LocalMappingReport& report) const;
  void FuseLines(KeyFrameId id, std::span<const KeyFrameId> neighbours, Map& map) const;
  void CullLandmarks(KeyFrameId newest, Map& map, LocalMappingReport& report);
  // Of those around the newest, after its adjustment. Returns the landmarks that they saw.
  Landmarks CullKeyFrames(Map& map, LocalMappingReport& report) const;
  bool IsRedundant(const KeyFrame& keyframe, const Map& map) const;
  // Drops those that too few keyframes see.
  void CullUnseen(const Landmarks& landmarks, Map& map) const;
  // Begins the adjustment of the keyframe and its neighbours.
  void AdjustAround(KeyFrameId id, const Map& map);
  void RefreshPoints(KeyFrameId id, Map& map) const;
  // The feature, its depth included, may be a sight of p_W.
  bool FitsDepth(const PointFeature& feature, const Pose& T_WC, const Eigen::Vector3d& p_W) const;

  template <class Landmark>
  bool Fails(const Landmark& landmark, KeyFrameId created, KeyFrameId newest) const;

  const MeasurementModel& model_;
  int levels_;
  LocalMapperOptions options_;
  MapMatcher matcher_;
  // On probation: landmark and the keyframe that created it, oldest first.
  std::deque<std::pair<PointId, KeyFrameId>> recent_points_;
  std::deque<std::pair<LineId, KeyFrameId>> recent_lines_;
  KeyFrameId newest_ = kNoId;
  std::unique_ptr<Adjustment> adjustment_;  // not applied yet
};

}  // namespace highwall
