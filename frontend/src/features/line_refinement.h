#pragma once

#include <vector>

#include <highwall/frontend/features/line_extractor.h>

#include "features/image_gradient.h"

namespace highwall::internal {

// Swaps the ends if the brighter side is not to the left (see LineSegment).
LineSegment OrientByGradient(const ImageGradient& gradient, const LineSegment& segment);

// Merges oriented fragments of one straight edge: nearly parallel, within a pixel and a half of the
// longer one's line, the gap along it at most `max_gap` [px]. Returns the longest first.
std::vector<LineSegment> MergeCollinear(std::vector<LineSegment> segments, float max_gap);

// Returns the oriented segment shifted and rotated to the sub-pixel peaks of the gradient across it
// (robust line fit to the peaks in at most 64 of the rows, or columns, that it crosses); unchanged
// if there are too few peaks. Its ends move only across the segment.
LineSegment RefineSegment(const ImageGradient& gradient, const LineSegment& segment);

}  // namespace highwall::internal
