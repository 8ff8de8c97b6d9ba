#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/features2d.hpp>

#include <highwall/frontend/features/options.h>
#include <highwall/frontend/features/point_extractor.h>

namespace highwall {

// SIFT (Lowe 2004) as OpenCV has it, spread evenly over the image as ORB's corners are. Descriptors
// are RootSIFT (Arandjelovic, Zisserman 2012): their correlation tells more than that of SIFT.
class SiftExtractor final : public PointExtractor {
 public:
  // Throws InvalidArgument naming the bad option.
  explicit SiftExtractor(const SiftExtractorOptions& options = {});

  // "sift", 128 floats; a level for each of the three layers of an octave, the first octave that of
  // the image at twice its size.
  const PointKind& kind() const override { return kind_; }
  ExtractedPoints Extract(const cv::Mat& gray) override;

 private:
  SiftExtractorOptions options_;
  PointKind kind_;
  cv::Ptr<cv::SIFT> sift_;
};

}  // namespace highwall
