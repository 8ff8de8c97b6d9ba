#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <highwall/core/stamp.h>

#include "support/seen_surface.h"

namespace highwall::bench {

// By the truth alone: when do the parts of a sequence come together? A part that begins with what
// has been seen before belongs to what showed it.
class Encounters {
 public:
  // Share of an image that makes it one of a known place.
  static constexpr double kKnown = 0.3;

  // Frames in their order. points: of the surface, SeenSurface::PointsOf().
  void Watch(Stamp stamp, int part, const testing::SeenSurface::Points& points);

  // When a frame has first shown a place that was known, but not to be connected with its own.
  std::optional<Stamp> met() const { return met_; }
  // How much of the first image of each part had been seen before.
  const std::vector<double>& known_at_first() const { return known_at_first_; }

 private:
  std::optional<int> part_;
  std::size_t place_ = 0;                     // of the part
  std::vector<testing::SeenSurface> places_;  // not known to be connected
  std::optional<Stamp> met_;
  std::vector<double> known_at_first_;
};

}  // namespace highwall::bench
