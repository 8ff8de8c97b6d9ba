#pragma once

#include <memory>

#include <opencv2/core/mat.hpp>

#include <highwall/frontend/features/options.h>
#include <highwall/frontend/features/point_extractor.h>

namespace [[gnu::visibility("default")]] highwall {

// Oriented FAST corners with rotated BRIEF descriptors (Rublee, Rabaud, Konolige, Bradski 2011) on
// a scale pyramid, spread evenly over the image: weak corners where there are no strong ones, and
// strongest-first suppression by squares whose side is chosen so that the budget is met (Bailo et
// al. 2018). Descriptors agree with those of cv::ORB up to the rounding of the smoothed image.
//
// Keypoints are ordered by octave, the strongest first; their response is the FAST score, their
// size [px] the diameter of the described patch. Extract() may be called from several threads at
// the same time; its result does not depend on cv::setNumThreads().
class OrbExtractor final : public PointExtractor {
 public:
  // Throws InvalidArgument naming the bad option.
  explicit OrbExtractor(const OrbExtractorOptions& options = {});
  ~OrbExtractor() override;
  OrbExtractor(OrbExtractor&&) noexcept;
  OrbExtractor& operator=(OrbExtractor&&) noexcept;

  // Returns "orb", 256 bits.
  const FeatureType& kind() const override;
  // gray: CV_8UC1. Returns no points for an image without texture or too small for a patch. Throws
  // InvalidArgument for any other type or an empty image.
  ExtractedPoints Extract(const cv::Mat& gray) override;

  // Returns scale_factor^level: the size of a pixel of that level in pixels of the image.
  double Scale(int level) const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

}  // namespace highwall
