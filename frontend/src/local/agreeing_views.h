#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include <highwall/frontend/map/map.h>

namespace highwall {

// A landmark without accurate depth in the keyframes that observe it.
template <class Landmark>
struct Depthless {
  typename LandmarkTraits<Landmark>::Geometry geometry_W;  // as observed by the newest keyframe
  std::vector<Observation> observations;                   // that of the newest keyframe first
};

// Views of a potential landmark with their observations; the first is the query feature.
template <class View>
struct Track {
  std::vector<View> views;
  std::vector<Observation> observations;

  void Add(const View& view, const Observation& observation) {
    views.push_back(view);
    observations.push_back(observation);
  }
  void AddFirst(const View& view, const Observation& observation) {
    views.insert(views.begin(), view);
    observations.insert(observations.begin(), observation);
  }
  void LeaveOut(std::size_t i) {
    views.erase(views.begin() + static_cast<std::ptrdiff_t>(i));
    observations.erase(observations.begin() + static_cast<std::ptrdiff_t>(i));
  }
};

// Returns the estimate from the largest consistent set of views: inconsistent views are removed one
// by one, worst first, but never the first view. Empty if fewer than min_views remain or no
// estimate follows from them.
// estimate: views -> optional landmark. misfits: landmark, views -> for each view |r|^2 over its
// bound; a view with more than 1 is inconsistent.
template <class View, class Estimate, class Misfits>
auto EstimateAgreeing(Track<View>& track, int min_views, const Estimate& estimate,
                      const Misfits& misfits)
    -> decltype(estimate(std::span<const View>(track.views))) {
  while (static_cast<int>(track.views.size()) >= min_views) {
    const std::span<const View> views = track.views;
    const auto landmark = estimate(views);
    if (!landmark) return landmark;
    const std::vector<double> all = misfits(*landmark, views);
    if (*std::max_element(all.begin(), all.end()) <= 1.0) return landmark;
    const auto worst = std::max_element(all.begin() + 1, all.end());
    track.LeaveOut(static_cast<std::size_t>(worst - all.begin()));
  }
  return {};
}

}  // namespace highwall
