#pragma once

#include <cstddef>

#include <highwall/frontend/map/landmark.h>

namespace highwall {

// Returns the support of a pose: a line counts as two points, because both of its ends are
// measured.
constexpr int Support(int points, int lines) {
  return points + 2 * lines;
}
constexpr std::size_t Support(std::size_t points, std::size_t lines) {
  return points + 2 * lines;
}

// Number of landmarks of one kind: PerKind<NumOfKind> are those of all kinds. Only points and lines
// support a pose.
template <class Landmark>
using NumOfKind = int;
constexpr int Support(const PerKind<NumOfKind>& landmarks) {
  return Support(landmarks.points, landmarks.lines);
}

// The same of a structure with a list of landmarks for each kind.
template <class Holder>
std::size_t SupportOf(const Holder& landmarks) {
  return Support(PartOf<MapPoint>(landmarks).size(), PartOf<MapLine>(landmarks).size());
}

}  // namespace highwall
