#include "features/memory_bytes.h"

namespace highwall {

std::size_t BytesOf(const FrameFeatures& features) {
  return sizeof(FrameFeatures) + BytesOf(features.points) + BytesOf(features.lines) +
         features.point_grid.MemoryBytes() + BytesOf(features.point_descriptors) +
         BytesOf(features.line_descriptors) + BytesOf(features.depth_grid) +
         BytesOf(features.gray_grid) + BytesOf(features.gray);
}

std::shared_ptr<const FrameFeatures> WithoutImages(const FrameFeatures& features) {
  auto without = std::make_shared<FrameFeatures>(features);
  without->gray.release();
  without->gray_grid.release();
  return without;
}

}  // namespace highwall
