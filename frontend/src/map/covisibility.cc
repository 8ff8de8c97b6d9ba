#include "map/covisibility.h"

#include <algorithm>
#include <cstddef>

namespace highwall {
namespace {

std::vector<KeyFrameId> Append(const Map& map, KeyFrameId centre, int min_shared, int most,
                               std::vector<KeyFrameId> keyframes) {
  const auto covisible = map.Covisible(centre, min_shared);
  const std::size_t size = std::min(covisible.size(), static_cast<std::size_t>(most));
  for (std::size_t i = 0; i < size; ++i) keyframes.push_back(covisible[i].first);
  return keyframes;
}

}  // namespace

std::vector<KeyFrameId> Neighbours(const Map& map, KeyFrameId centre, int min_shared, int most) {
  return Append(map, centre, min_shared, most, {});
}

std::vector<KeyFrameId> WithNeighbours(const Map& map, KeyFrameId centre, int min_shared,
                                       int most) {
  return Append(map, centre, min_shared, most, {centre});
}

}  // namespace highwall
