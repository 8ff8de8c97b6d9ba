#include "tracking/dynamic_features.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <vector>

#include "features/feature_kinds.h"
#include "pose/landmark_motion.h"
#include "pose/support.h"
#include "tracking/landmark_observations.h"

namespace highwall {
namespace {

// Returns the submap of the landmarks it was matched with (at least one).
SubmapId SubmapOf(const TrackedFrame& tracked, const Map& map) {
  const auto seen_by = [&](const auto* landmark) {
    return map.keyframe(landmark->observations.front().keyframe)->submap;
  };
  std::optional<SubmapId> submap;
  ForEachKind([&]<class Landmark>() {
    for (const Id<Landmark> id : PartOf<Landmark>(tracked)) {
      if (submap) return;
      if (const Landmark* const landmark = map.Find(id)) submap = seen_by(landmark);
    }
  });
  return submap.value_or(kFirstSubmap);
}

// Returns whether `is_on` holds for one of the pixels that represent a feature.
template <class Feature, class IsOn>
bool Touches(const Feature& feature, const IsOn& is_on) {
  return std::ranges::any_of(PixelsOf(feature), is_on);
}

// Returns a test of whether a pixel [px] is on a nonzero cell of the mask.
auto On(const cv::Mat& mask, const DepthGrid& grid) {
  return [&](const Eigen::Vector2d& uv) { return mask.at<std::uint8_t>(grid.CellOf(uv)) != 0; };
}

}  // namespace

DynamicFeatures::DynamicFeatures(const MeasurementModel& model, const DynamicObjectOptions& options,
                                 const DynamicObjectParameters& parameters)
    : model_(model),
      landmarks_(parameters.landmarks),
      objects_(model.camera(), model.depth_noise(), options, parameters) {}

bool DynamicFeatures::HasMoved(const TrackedFrame& rough, const Map& map,
                               const DepthSurfaces& surfaces, int surface,
                               const cv::Mat& moving) const {
  const FrameFeatures& features = *rough.frame.features;
  const auto is_on = [&](const Eigen::Vector2d& uv) {
    return surfaces.labels.at<int>(grid().CellOf(uv)) == surface;
  };
  const auto moves = On(moving, grid());
  std::vector<PosePoint> judged;
  PerKind<NumOfKind> on_surface{};
  TrackedFrame others = Unmatched(rough.frame, rough.T_WC);
  for (std::size_t i = 0; i < rough.tried.points.size(); ++i) {
    const MapPoint* point = map.Find(rough.tried.points[i]);
    if (point == nullptr) continue;
    if (is_on(features.points[i].uv)) {
      judged.push_back(MakePoseObservation(model_, *point, features.points[i]));
    } else if (!moves(features.points[i].uv)) {
      others.points[i] = point->id;
    }
  }
  if (static_cast<int>(judged.size()) < landmarks_.min_points) return false;
  ForEachKind([&]<class Landmark>() {
    if constexpr (!std::is_same_v<Landmark, MapPoint>) {
      const LandmarkIds<Landmark>& tried = PartOf<Landmark>(rough.tried);
      for (std::size_t i = 0; i < tried.size(); ++i) {
        if (tried[i] == kNoId) continue;
        const auto& feature = PartOf<Landmark>(features)[i];
        if (Touches(feature, is_on)) {
          ++PartOf<Landmark>(on_surface);
        } else if (!Touches(feature, moves)) {
          PartOf<Landmark>(others)[i] = tried[i];
        }
      }
    }
  });
  const LandmarkObservations seen = LandmarksSeen(model_, map, others);
  return HaveMoved(rough.T_WC, model_.projection(), judged, on_surface.lines, seen, landmarks_);
}

cv::Mat DynamicFeatures::Find(const TrackedFrame& tracked, const Map& map) const {
  return objects_.Find(tracked.frame.stamp, tracked.frame.features->depth_grid, tracked.T_WC, map,
                       SubmapOf(tracked, map),
                       [&](const DepthSurfaces& surfaces, int surface, const cv::Mat& moving) {
                         return HasMoved(tracked, map, surfaces, surface, moving);
                       });
}

int DynamicFeatures::SupportBeside(const TrackedFrame& tracked, const cv::Mat& moving) const {
  const FrameFeatures& features = *tracked.frame.features;
  const auto moves = On(moving, grid());
  PerKind<NumOfKind> beside{};
  ForEachKind([&]<class Landmark>() {
    const LandmarkIds<Landmark>& landmarks = PartOf<Landmark>(tracked);
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
      const bool is_beside =
          landmarks[i] != kNoId && !Touches(PartOf<Landmark>(features)[i], moves);
      PartOf<Landmark>(beside) += is_beside ? 1 : 0;
    }
  });
  return highwall::Support(beside);
}

void DynamicFeatures::MaskOut(TrackedFrame& rough) const {
  if (rough.moving.empty()) return;
  const FrameFeatures& features = *rough.frame.features;
  const cv::Mat aside = WithBorder(rough.moving);
  const auto moves = On(aside, grid());
  const auto keep = [](const std::vector<bool>& flags, auto& landmarks) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < flags.size(); ++i) {
      if (flags[i]) landmarks[n++] = landmarks[i];
    }
    landmarks.resize(n);
  };
  FeatureFlags kept;
  ForEachKind([&]<class Landmark>() {
    std::vector<bool>& flags = PartOf<Landmark>(kept);
    for (const auto& feature : PartOf<Landmark>(features)) {
      flags.push_back(!Touches(feature, moves));
    }
    keep(flags, PartOf<Landmark>(rough));
  });
  const PinholeCamera& camera = model_.camera();
  rough.frame.features = Select(features, kept, {camera.width, camera.height});
}

}  // namespace highwall
