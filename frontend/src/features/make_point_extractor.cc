#include <highwall/frontend/features/make_point_extractor.h>
#include <highwall/frontend/features/orb_extractor.h>

#include "features/sift_extractor.h"

namespace highwall {

std::shared_ptr<PointExtractor> MakePointExtractor(const FrameBuilderOptions& options) {
  if (options.point_detector == PointDetector::kSift) {
    return std::make_shared<SiftExtractor>(options.sift);
  }
  return std::make_shared<OrbExtractor>(options.orb);
}

}  // namespace highwall
