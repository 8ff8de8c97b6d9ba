#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <highwall/frontend/local/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_report.h>
#include <highwall/frontend/map/measurement_model.h>

#include "local/bundle_adjustment.h"
#include "local/corner_refiner.h"
#include "map/map_matcher.h"
#include "tracking/tracked_frame.h"

namespace highwall {

// Grows and cleans the map, a keyframe at a time: landmarks from depth, fusion with those of
// neighbouring keyframes, culling, local bundle adjustment. (Xiao et al. 2025, figure 2, local
// mapping.)
class LocalMapper {
 public:
  // model: must outlive the mapper.
  LocalMapper(const MeasurementModel& model, const LocalMapperOptions& options);
  // An adjustment that still runs is cancelled.
  ~LocalMapper();
  LocalMapper(const LocalMapper&) = delete;
  LocalMapper& operator=(const LocalMapper&) = delete;

  // First applies the adjustment of the keyframe before, where Finish() has not. motion: of the
  // body, where an IMU tells it.
  LocalMappingReport InsertKeyFrame(const TrackedFrame& tracked, Map& map,
                                    std::optional<KeyFrameMotion> motion = std::nullopt);

  // An adjustment is done and waits to be applied.
  bool HasResult() const;
  // Applies to the map the adjustment that is done, or, in Finish(), that is waited for; between
  // frames. Empty where there is none.
  std::optional<BundleAdjustmentReport> Update(Map* map);
  std::optional<BundleAdjustmentReport> Finish(Map* map);
  // Ends the adjustment that runs; nothing of it is applied: of a map that moves meanwhile.
  void Cancel();

 private:
  class Adjustment;
  struct Landmarks {
    std::vector<PointId> points;
    std::vector<LineId> lines;
  };

  void CreatePoints(KeyFrame& keyframe, Map& map, LocalMappingReport& report);
  void CreateLines(const KeyFrame& keyframe, Map& map, LocalMappingReport& report);
  // Of corners and of segments whose depth is missing.
  void TriangulatePoints(const KeyFrame& keyframe, Map& map, LocalMappingReport& report);
  void TriangulateLines(const KeyFrame& keyframe, Map& map, LocalMappingReport& report);
  // A landmark that looks like segment `index` of the keyframe.
  LineId AddLine(const KeyFrame& keyframe, int index, const Segment3& segment_W, Map& map);
  // Finds the landmarks of neighbouring keyframes that this one observes without having been
  // tracked to them.
  void FuseNeighbours(KeyFrameId id, Map& map, LocalMappingReport& report) const;
  void CullLandmarks(KeyFrameId newest, Map& map, LocalMappingReport& report);
  // Of those around the newest, after its adjustment. Returns the landmarks that they observed.
  Landmarks CullKeyFrames(Map& map, LocalMappingReport& report) const;
  bool IsRedundant(const KeyFrame& keyframe, const Map& map) const;
  // Drops those that too few keyframes observe.
  void CullUnseen(const Landmarks& landmarks, Map& map) const;
  // Begins the adjustment of the keyframe and its neighbours.
  void AdjustAround(KeyFrameId id, const Map& map);
  void RefreshPoints(KeyFrameId id, Map& map) const;

  template <class Landmark>
  bool Fails(const Landmark& landmark, KeyFrameId created, KeyFrameId newest) const;

  const MeasurementModel& model_;
  LocalMapperOptions options_;
  MapMatcher matcher_;
  CornerRefiner corners_;
  // On probation: landmark and the keyframe that created it, oldest first.
  std::deque<std::pair<PointId, KeyFrameId>> recent_points_;
  std::deque<std::pair<LineId, KeyFrameId>> recent_lines_;
  KeyFrameId newest_ = kNoId;
  std::unique_ptr<Adjustment> adjustment_;  // not applied yet
};

}  // namespace highwall
