#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace highwall::apps {

// Counts colour images of a recording in which nothing can be tracked.
class ImageSurvey {
 public:
  // bgr: CV_8UC3.
  void Add(const cv::Mat& bgr);

  std::size_t dark() const { return dark_; }    // black or nearly so, without corners and edges
  std::size_t plain() const { return plain_; }  // bright enough, but without corners and edges
  // Human-readable lines, one per problem that affects more than one image in twenty.
  std::vector<std::string> Problems() const;

 private:
  std::size_t count_ = 0, dark_ = 0, plain_ = 0;
};

}  // namespace highwall::apps
