#pragma once

#include <memory>

#include <highwall/frontend/features/options.h>
#include <highwall/frontend/features/point_extractor.h>

namespace [[gnu::visibility("default")]] highwall {

// Creates the extractor of FrameBuilderOptions::point_detector. Throws InvalidArgument naming a
// field of its options.
std::shared_ptr<PointExtractor> MakePointExtractor(const FrameBuilderOptions& options);

}  // namespace highwall
