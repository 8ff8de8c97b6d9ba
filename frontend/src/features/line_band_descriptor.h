#pragma once

#include <array>
#include <cstdint>

#include <highwall/frontend/features/line_extractor.h>

#include "features/image_gradient.h"

namespace highwall::internal {

// Binary line band descriptor of an oriented segment (Zhang, Koch, "An efficient and robust line
// segment matching approach based on LBD descriptor and pairwise geometric consistency", 2013):
// 9 bands of 7 pixels parallel to the segment, in each the mean and the standard deviation of the
// gradient towards the left, right, front and back; a bit for each statistic and pair of bands.
// Valid wherever the segment lies, also at the border of the image.
std::array<std::uint8_t, 32> LineBandDescriptor(const ImageGradient& gradient,
                                                const LineSegment& segment);

}  // namespace highwall::internal
