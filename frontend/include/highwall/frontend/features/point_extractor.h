#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include <highwall/core/abi.h>
#include <highwall/frontend/features/options.h>

namespace [[gnu::visibility("default")]] highwall {

// The points detected in one image; row i of `descriptors` belongs to keypoint i.
struct ExtractedPoints {
  // pt [px of the image, the centre of its first pixel is (0, 0)], octave (level of
  // FeatureType::pyramid), angle [deg, 0 to 360, from x towards y; negative: none], response. In
  // any order; `size` is not used.
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;  // N x FeatureType::columns; empty where there are no keypoints
};

// Element type of a descriptor row.
enum class DescriptorType {
  kBinary,  // CV_8U, eight bits per column, similar if few bits differ
  kFloat,   // CV_32F, similar if their Pearson correlation is high
};

// Properties of the points of an extractor: all that the system needs besides the points
// themselves.
struct FeatureType {
  // name of the kind of descriptor: only descriptors of the same name are comparable
  std::string name = "orb";
  DescriptorType descriptor = DescriptorType::kBinary;
  int columns = 32;  // of a descriptor, > 0
  // From level to level a point is coarser by `scale_factor`, and so are its noise and the distance
  // it is seen from. With one level the factor bounds how much nearer or farther it may be seen.
  PyramidOptions pyramid{};
  // points of a weaker response are low contrast and may be mere noise: none starts a map
  float low_contrast_response = 0.0F;

  // Throws InvalidArgument naming the extractor and the field.
  void Validate() const;
};

// Detects and describes the points of images. A user-defined extractor replaces ORB in SlamSystem
// (docs/user_features.md).
class PointExtractor {
 public:
  virtual ~PointExtractor();

  // Constant over the lifetime of the extractor.
  virtual const FeatureType& kind() const = 0;

  // gray: CV_8UC1, not empty, the raw (distorted) camera image. The same image must give the same
  // points. Called from one thread at a time, but not always the same one. An exception thrown here
  // ends the Track() call that requested it.
  virtual ExtractedPoints Extract(const cv::Mat& gray) = 0;

 protected:
  PointExtractor() = default;
  PointExtractor(const PointExtractor&) = default;
  PointExtractor& operator=(const PointExtractor&) = default;
};

}  // namespace highwall
