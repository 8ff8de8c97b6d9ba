#include "features/memory_bytes.h"

namespace highwall {

std::size_t BytesOf(const FrameFeatures& features) {
  return sizeof(FrameFeatures) + BytesOf(features.points) + BytesOf(features.lines) +
         features.point_grid.MemoryBytes() + BytesOf(features.point_descriptors) +
         BytesOf(features.line_descriptors) + BytesOf(features.depth_grid) +
         BytesOf(features.gray_grid) + BytesOf(features.gray);
}

}  // namespace highwall
