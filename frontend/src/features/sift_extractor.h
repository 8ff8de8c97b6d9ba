#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/features2d.hpp>

#include <highwall/frontend/features/options.h>
#include <highwall/frontend/features/point_extractor.h>

namespace highwall {

// SIFT (Lowe 2004) by OpenCV, spread evenly over the image like the corners of ORB. Descriptors are
// RootSIFT (Arandjelovic, Zisserman 2012), whose correlation is more discriminative than that of
// SIFT.
class SiftExtractor final : public PointExtractor {
 public:
  // Throws InvalidArgument naming the bad option.
  explicit SiftExtractor(const SiftExtractorOptions& options = {});

  // Returns "sift", 128 floats; one level for each of the three layers of an octave, the first
  // octave being that of the image at twice its size.
  const FeatureType& kind() const override { return kind_; }
  ExtractedPoints Extract(const cv::Mat& gray) override;

 private:
  SiftExtractorOptions options_;
  FeatureType kind_;
  cv::Ptr<cv::SIFT> sift_;
};

}  // namespace highwall
