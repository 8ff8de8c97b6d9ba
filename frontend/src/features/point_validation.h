#pragma once

#include <opencv2/core/types.hpp>

#include <highwall/frontend/features/point_extractor.h>

namespace highwall {

// Throws InvalidArgument, naming the extractor and the fault, if the points are not as
// PointExtractor says: a keypoint outside of the image, of no level or not finite, descriptors of
// another type or number of columns, not one for each keypoint, or not finite.
void ValidatePoints(const ExtractedPoints& points, const FeatureType& kind, const cv::Size& image);

}  // namespace highwall
