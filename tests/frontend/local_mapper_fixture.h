#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "local/local_mapper.h"
#include "support/synthetic_scene.h"

namespace highwall::testing {

// Returns a pose along x, rotating to the right.
inline Pose At(double x) {
  return Pose::FromTangent({x, 0, 0}, {0, 0.1 * x, 0});
}

// A mapper that is given the views of a scene, keyframe by keyframe.
class LocalMapperTest : public ::testing::Test {
 protected:
  LocalMapperTest() : point_ids(scene.points.size(), kNoId), line_ids(scene.lines.size(), kNoId) {}

  // Returns the result of perfect tracking: every feature whose landmark is in the map.
  TrackedFrame Tracked(const SyntheticView& view, const Pose& T_WC) const {
    TrackedFrame tracked;
    tracked.frame = MakeFrame(view, static_cast<std::int64_t>(map.num_keyframes()));
    tracked.state = TrackingState::kTracking;
    tracked.T_WC = T_WC;
    for (const int i : view.points) {
      const PointId id = point_ids[static_cast<std::size_t>(i)];
      tracked.points.push_back(map.Find(id) != nullptr ? id : kNoId);
    }
    for (const int i : view.lines) {
      const LineId id = line_ids[static_cast<std::size_t>(i)];
      tracked.lines.push_back(map.Find(id) != nullptr ? id : kNoId);
    }
    const auto count = [](const auto& ids) {
      return static_cast<int>(
          std::count_if(ids.begin(), ids.end(), [](auto id) { return id != kNoId; }));
    };
    tracked.num_points = count(tracked.points);
    tracked.num_lines = count(tracked.lines);
    return tracked;
  }
  LocalMappingReport Insert(LocalMapper& mapper, const SyntheticView& view,
                            const TrackedFrame& tracked,
                            std::optional<InertialState> motion = std::nullopt) {
    LocalMappingReport report = mapper.InsertKeyFrame(tracked, map, std::move(motion));
    if (finish_) report.bundle = mapper.Finish(&map).value_or(report.bundle);
    const KeyFrame& keyframe = *map.keyframe(report.keyframe);
    for (std::size_t i = 0; i < view.points.size(); ++i) {
      if (keyframe.points[i] == kNoId) continue;
      point_ids[static_cast<std::size_t>(view.points[i])] = keyframe.points[i];
    }
    for (std::size_t i = 0; i < view.lines.size(); ++i) {
      if (keyframe.lines[i] == kNoId) continue;
      line_ids[static_cast<std::size_t>(view.lines[i])] = keyframe.lines[i];
    }
    return report;
  }
  LocalMappingReport Insert(LocalMapper& mapper, const SyntheticView& view, const Pose& T_WC) {
    return Insert(mapper, view, Tracked(view, T_WC));
  }
  LocalMappingReport InsertAt(LocalMapper& mapper, double x) {
    return Insert(mapper, Look(scene, IdealSensor(), At(x)), At(x));
  }
  // Adds a keyframe with a wrong pose, whose adjustment waits to be applied.
  Pose InsertWrongly(LocalMapper& mapper) {
    finish_ = false;
    InsertAt(mapper, 0.0);
    Eigen::Matrix<double, 6, 1> error;
    error << 0.003, -0.002, 0.002, 0.001, 0.001, -0.001;
    const Pose wrong = At(0.1).Plus(error);
    const SyntheticView view = Look(scene, IdealSensor(), At(0.1));
    Insert(mapper, view, Tracked(view, wrong));
    return wrong;
  }

  const MeasurementModel model{IdealSensor(), {}};
  const Scene scene = MakeScene(23, 300, 40);
  Map map;
  std::vector<PointId> point_ids;  // by index in the scene
  std::vector<LineId> line_ids;
  bool finish_ = true;  // finish the adjustment of a keyframe first
};

}  // namespace highwall::testing
