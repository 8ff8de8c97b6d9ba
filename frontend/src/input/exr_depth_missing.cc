// Compiled in place of exr_depth.cc where OpenEXR is not installed.
#include <highwall/core/error.h>

#include "input/exr_depth.h"

namespace highwall {

cv::Mat ReadExrDepth(const std::filesystem::path& path) {
  throw IoError(path,
                "is of OpenEXR, which this build does not read: install libopenexr-dev and build "
                "again");
}

}  // namespace highwall
