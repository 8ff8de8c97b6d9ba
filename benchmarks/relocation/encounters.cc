#include "encounters.h"

#include <algorithm>
#include <cstddef>

namespace highwall::bench {

void Encounters::Watch(Stamp stamp, int part, const testing::SeenSurface::Points& points) {
  if (part != part_) {
    part_ = part;
    place_ = places_.size();
    double most = 0.0;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const double share = places_[i].ShareSeen(points);
      if (share >= std::max(most, kKnown)) place_ = i;
      most = std::max(most, share);
    }
    known_at_first_.push_back(most);
    if (place_ == places_.size()) places_.emplace_back();
  }
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (i == place_ || places_[i].ShareSeen(points) < kKnown) continue;
    if (!met_) met_ = stamp;
    const auto [first, second] = std::minmax(i, place_);
    places_[first].Add(places_[second]);
    places_.erase(places_.begin() + static_cast<std::ptrdiff_t>(second));
    place_ = first;
    break;
  }
  places_[place_].Add(points);
}

}  // namespace highwall::bench
