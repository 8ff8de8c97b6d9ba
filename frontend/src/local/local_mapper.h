#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <highwall/frontend/local/bundle_adjustment.h>
#include <highwall/frontend/local/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_report.h>
#include <highwall/frontend/map/measurement_model.h>

#include "local/agreeing_views.h"
#include "local/corner_refiner.h"
#include "local/depthless_landmarks.h"
#include "map/map_matcher.h"
#include "map/map_stage.h"
#include "tracking/tracked_frame.h"

namespace highwall {

class RunProfile;

// Parameters of LocalMapper that are no options of a user.
struct LocalMapperParameters {
  BundleAdjustmentOptions bundle{};
  TriangulationOptions triangulation{};
  // >= 1: keyframes created until a new landmark must have LocalMapperOptions::min_observations.
  int probation_keyframes = 3;
  // >= 1: keyframes that must observe a landmark for it not to need one more; for a line twice as
  // many, since lines are matched less often.
  int redundant_observers = 2;
  double motion_span = 20.0;      // [s] >= 0: age up to which IMU factors stay short
  double min_line_length = 0.05;  // [m] > 0: shorter segments create no landmark
};

// Extends and cleans the map, one keyframe at a time: landmarks from depth, fusion with those of
// neighbouring keyframes, culling, local bundle adjustment. (Xiao et al. 2025, figure 2, local
// mapping.)
class LocalMapper final : public MapStage {
 public:
  // model: must outlive the mapper. background: the adjustment runs on a thread of its own and is
  // applied between frames; otherwise before InsertKeyFrame() returns, and the same input gives the
  // same map. profile: null: none; must outlive the mapper.
  LocalMapper(const MeasurementModel& model, const LocalMapperOptions& options,
              bool background = true, const LocalMapperParameters& parameters = {},
              RunProfile* profile = nullptr);
  // Cancels an adjustment that still runs.
  ~LocalMapper() override;
  LocalMapper(const LocalMapper&) = delete;
  LocalMapper& operator=(const LocalMapper&) = delete;

  // Applies the previous keyframe's adjustment first, unless Finish() has done so. motion: of the
  // body, if an IMU estimates it.
  LocalMappingReport InsertKeyFrame(const TrackedFrame& tracked, Map& map,
                                    std::optional<InertialState> motion = std::nullopt);

  // Returns whether an adjustment is done and waits to be applied.
  bool HasResult() const;
  // Applies an adjustment to the map, between frames: Update() if it is done, Finish() after
  // waiting for it. Empty if there is none.
  std::optional<BundleAdjustmentReport> Update(Map* map);
  std::optional<BundleAdjustmentReport> Finish(Map* map);
  bool IsIdle() const override { return adjustment_ == nullptr; }
  SubmapId submap() const override;
  // Requests the adjustment to end and waits for the current iteration.
  void Drop() override;

 private:
  class Adjustment;
  // Landmarks on probation, each with the keyframe that created it, oldest first.
  template <class Landmark>
  using Recent = std::deque<std::pair<Id<Landmark>, KeyFrameId>>;

  // Creates landmarks observed by a new keyframe.
  void CreateLandmarks(const KeyFrame& keyframe, bool scarce_points, Map& map,
                       LocalMappingReport& report);
  // Creates landmarks of one kind from depth. Returns their number, as do the following.
  template <class Landmark>
  int CreateFromDepth(const KeyFrame& keyframe, Map& map);
  // Triangulates features of a keyframe without depth: points, and lines if points are scarce.
  template <class Landmark>
  std::vector<Depthless<Landmark>> FindDepthless(KeyFrameId id, bool scarce_points,
                                                 const Map& map) const;
  // Creates landmarks from them.
  template <class Landmark>
  int CreateFrom(const std::vector<Depthless<Landmark>>& found, const KeyFrame& keyframe, Map& map);
  // observations: that of the keyframe first.
  template <class Landmark>
  void Create(const typename LandmarkTraits<Landmark>::Geometry& geometry_W,
              std::span<const Observation> observations, const KeyFrame& keyframe, Map& map);
  // Fuses landmarks of neighbouring keyframes that match features of this one but were not tracked.
  void FuseNeighbours(KeyFrameId id, Map& map, LocalMappingReport& report) const;
  // Removes landmarks on probation that fail. Returns their number.
  template <class Landmark>
  int CullRecent(KeyFrameId newest, Map& map);
  // Culls keyframes around the newest, after its adjustment. Returns the landmarks that they
  // observed.
  PerKind<LandmarkIds> CullKeyFrames(Map& map, LocalMappingReport& report) const;
  bool IsRedundant(const KeyFrame& keyframe, const Map& map) const;
  // Removes those with too few observations.
  void CullUnseen(const PerKind<LandmarkIds>& landmarks, Map& map) const;
  // Begins the adjustment of the keyframe and its neighbours.
  void AdjustAround(KeyFrameId id, const Map& map);
  void RefreshPoints(KeyFrameId id, Map& map) const;

  template <class Landmark>
  bool Fails(const Landmark& landmark, KeyFrameId created, KeyFrameId newest) const;

  const MeasurementModel& model_;
  LocalMapperOptions options_;
  LocalMapperParameters parameters_;
  const bool background_;
  RunProfile* const profile_;
  MapMatcher matcher_;
  CornerRefiner corners_;
  PerKind<Recent> recent_;
  KeyFrameId newest_ = kNoId;
  std::unique_ptr<Adjustment> adjustment_;  // not yet applied
};

}  // namespace highwall
