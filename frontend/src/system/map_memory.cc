#include "system/map_memory.h"

#include <cstddef>

#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/map/keyframe_index.h>

#include "features/memory_bytes.h"
#include "local/corner_patch.h"

namespace highwall {
namespace {

std::size_t KeyFrameBytes(const KeyFrame& keyframe) {
  // Without dynamic objects its depth grid is that of its features.
  const cv::Mat& of_features = keyframe.frame.features->depth_grid;
  const bool is_shared = keyframe.depth_grid.data == of_features.data;
  return sizeof(KeyFrame) + BytesOf(keyframe.points) + BytesOf(keyframe.lines) +
         (is_shared ? 0 : BytesOf(keyframe.depth_grid)) +
         (keyframe.motion && keyframe.motion->from_previous ? sizeof(ImuPreintegration) : 0);
}

template <LandmarkKind Landmark>
std::size_t LandmarkBytes(const Map& map) {
  std::size_t bytes = 0;
  for (const Id<Landmark> id : map.ids<Landmark>()) {
    bytes += sizeof(Landmark) + BytesOf(map.Find(id)->observations);
  }
  return bytes;
}

std::size_t PatchBytes(const Map& map) {
  std::size_t bytes = 0;
  for (const PointId id : map.ids<MapPoint>()) {
    if (map.Find(id)->patch != nullptr) bytes += sizeof(CornerPatch);
  }
  return bytes;
}

}  // namespace

std::vector<MemoryShare> MemoryOf(const Map& map) {
  std::size_t features = 0, keyframes = 0;
  for (const KeyFrameId id : map.keyframe_ids()) {
    const KeyFrame& keyframe = *map.keyframe(id);
    features += BytesOf(*keyframe.frame.features);
    keyframes += KeyFrameBytes(keyframe);
  }
  return {{"features of keyframes", features},      {"keyframes", keyframes},
          {"points", LandmarkBytes<MapPoint>(map)}, {"corner patches of points", PatchBytes(map)},
          {"lines", LandmarkBytes<MapLine>(map)},   {"index of places", map.index().MemoryBytes()}};
}

}  // namespace highwall
