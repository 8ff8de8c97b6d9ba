#include <highwall/frontend/map/seen_landmarks.h>

#include <cstddef>
#include <set>
#include <utility>

namespace highwall {
namespace {

// Number of keyframes; earlier ones add little information on the position of a landmark.
constexpr std::size_t kMostViews = 5;

// Collects the observations of landmarks in a map.
class Finder {
 public:
  explicit Finder(const Map& map) : map_(map) {}

  // Returns the latest observations.
  template <class Landmark>
  auto LatestViews(const std::vector<Observation>& observations) {
    std::vector<MapView<typename LandmarkTraits<Landmark>::Feature>> views;
    for (std::size_t i = observations.size(); i-- > 0 && views.size() < kMostViews;) {
      const KeyFrame* keyframe = map_.keyframe(observations[i].keyframe);
      if (keyframe == nullptr) continue;
      if (known_.insert(keyframe->id).second) kept_.push_back(keyframe->frame.features);
      const auto& features = PartOf<Landmark>(*keyframe->frame.features);
      views.push_back({keyframe->T_WC, &features[static_cast<std::size_t>(observations[i].index)]});
    }
    return views;
  }
  std::vector<std::shared_ptr<const FrameFeatures>> TakeFeatures() { return std::move(kept_); }

 private:
  const Map& map_;
  std::set<KeyFrameId> known_;
  std::vector<std::shared_ptr<const FrameFeatures>> kept_;
};

}  // namespace

SeenLandmarks FindSeen(const Map& map, const std::shared_ptr<const FrameFeatures>& features,
                       const PerKind<LandmarkIds>& matched, double error) {
  SeenLandmarks seen;
  seen.error = error;
  Finder finder(map);
  ForEachKind([&]<class Landmark>() {
    const LandmarkIds<Landmark>& ids = PartOf<Landmark>(matched);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      const Landmark* const landmark = map.Find(ids[i]);
      if (landmark == nullptr) continue;
      PartOf<Landmark>(seen).push_back(
          {landmark->id, LandmarkTraits<Landmark>::PositionOf(*landmark),
           &PartOf<Landmark>(*features)[i], finder.LatestViews<Landmark>(landmark->observations)});
    }
  });
  seen.features = finder.TakeFeatures();
  seen.features.push_back(features);
  return seen;
}

}  // namespace highwall
