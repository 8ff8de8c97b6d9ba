#pragma once

#include <vector>

#include "features/image_gradient.h"
#include "features/line_extractor.h"

namespace highwall::internal {

// Swaps the ends where the brighter side is not to the left (see LineSegment).
LineSegment OrientByGradient(const ImageGradient& gradient, const LineSegment& segment);

// Joins oriented fragments of one straight edge: nearly parallel, within a pixel and a half of the
// longer one's line, the gap along it at most `max_gap` [px]. The longest come first.
std::vector<LineSegment> MergeCollinear(std::vector<LineSegment> segments, float max_gap);

// The oriented segment shifted and turned onto the sub-pixel peaks of the gradient across it
// (robust line fit to one peak every two pixels); unchanged where it has too few. Its ends move
// only across it.
LineSegment RefineSegment(const ImageGradient& gradient, const LineSegment& segment);

}  // namespace highwall::internal
