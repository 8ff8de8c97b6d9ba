#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <highwall/frontend/map/map.h>

namespace highwall {

// Map::SeenBy for queries in which nearly the same keyframes follow each other, in a map that does
// not change: counts for each landmark the keyframes that observe it, and updates the counts only
// for keyframes that come or go.
class LandmarksAround {
 public:
  // map: must outlive it.
  explicit LandmarksAround(const Map& map);

  // Sets the keyframes, in any order.
  void MoveTo(std::span<const KeyFrameId> keyframes);
  // Returns what Map::SeenBy returns for these keyframes.
  template <LandmarkKind Landmark>
  std::vector<Id<Landmark>> Except(std::span<const Id<Landmark>> except);

 private:
  template <class Landmark>
  struct Counts {
    Id<Landmark> first{0};  // of the map
    std::vector<std::uint16_t> observers;
  };

  template <class Landmark>
  std::uint16_t* Find(Id<Landmark> id);
  // Adds `step` to the counts of the landmarks of a keyframe.
  void Count(KeyFrameId keyframe, int step);

  const Map& map_;
  PerKind<Counts> counts_;
  std::vector<KeyFrameId> keyframes_;  // ascending
};

}  // namespace highwall
