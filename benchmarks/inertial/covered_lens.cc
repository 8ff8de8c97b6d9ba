#include "covered_lens.h"

#include <utility>

#include <fmt/core.h>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>

namespace highwall::bench {

RgbdImage CoveredLens::DoLoad(std::size_t index) const {
  std::optional<RgbdImage> image = dataset_.Load(index);
  if (!image) throw IoError(fmt::format("frame {}", index), "cannot be used");
  if (image->stamp >= begin_ && image->stamp <= end_) {
    image->bgr.setTo(0);
    image->depth.setTo(0);
  }
  return *std::move(image);
}

}  // namespace highwall::bench
