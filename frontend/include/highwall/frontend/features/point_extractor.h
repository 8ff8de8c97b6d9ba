#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include <highwall/core/abi.h>
#include <highwall/frontend/features/options.h>

namespace [[gnu::visibility("default")]] highwall {

// The points found in one image; row i of `descriptors` belongs to keypoint i.
struct ExtractedPoints {
  // pt [px of the image, the centre of its first pixel is (0, 0)], octave (level of
  // PointKind::pyramid), angle [deg, 0 to 360, from x towards y; negative: it has none], response.
  // Any order; `size` is not looked at.
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;  // N x PointKind::columns; empty where there are no keypoints
};

// What a row of descriptors is.
enum class DescriptorType {
  kBinary,  // CV_8U, eight bits a column, alike where few bits differ
  kFloat,   // CV_32F, alike where their Pearson correlation is high
};

// What points an extractor finds: all that the system need know of it beside the points themselves.
struct PointKind {
  std::string name = "orb";  // of the kind of descriptor: only those of one name are alike
  DescriptorType descriptor = DescriptorType::kBinary;
  int columns = 32;  // of a descriptor, > 0
  // By `scale_factor` a point is coarser from level to level, its noise and the distance it is seen
  // from likewise. With one level the factor says how much nearer or farther it may be seen.
  PyramidOptions pyramid{};
  float faint_response = 0.0F;  // points with less may be mere noise: none begins a map

  // Throws InvalidArgument naming the extractor and the field.
  void Validate() const;
};

// Finds and describes the points of images. One of your own takes the place of ORB in SlamSystem
// (docs/own_features.md).
class PointExtractor {
 public:
  virtual ~PointExtractor();

  // Stays the same.
  virtual const PointKind& kind() const = 0;

  // gray: CV_8UC1, not empty, as the camera gave it (distorted). The same image is to give the same
  // points. Called from one thread at a time, but not always the same. What it throws ends the
  // Track() that asked for it.
  virtual ExtractedPoints Extract(const cv::Mat& gray) = 0;

 protected:
  PointExtractor() = default;
  PointExtractor(const PointExtractor&) = default;
  PointExtractor& operator=(const PointExtractor&) = default;
};

}  // namespace highwall
