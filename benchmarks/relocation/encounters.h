#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <highwall/core/stamp.h>

#include "support/seen_surface.h"

namespace highwall::bench {

// Determines from the ground truth when the parts of a sequence come together. A part that begins
// with a known view belongs to the place that showed it.
class Encounters {
 public:
  // Share of an image that must be known for the image to show a known place.
  static constexpr double kKnown = 0.3;

  // Frames in their order. points: of the surface, SeenSurface::PointsOf().
  void Watch(Stamp stamp, int part, const testing::SeenSurface::Points& points);

  // Returns when a frame first showed a known place that was not known to be connected with its
  // own.
  std::optional<Stamp> met() const { return met_; }
  // Returns the known share of the first image of each part.
  const std::vector<double>& known_at_first() const { return known_at_first_; }

 private:
  std::optional<int> part_;
  std::size_t place_ = 0;                     // of the part
  std::vector<testing::SeenSurface> places_;  // not known to be connected
  std::optional<Stamp> met_;
  std::vector<double> known_at_first_;
};

}  // namespace highwall::bench
