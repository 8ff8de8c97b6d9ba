#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace highwall::apps {

// What the colour images of a recording lack, so that nothing can be tracked in them.
class ImageSurvey {
 public:
  // bgr: CV_8UC3.
  void Add(const cv::Mat& bgr);

  std::size_t dark() const { return dark_; }    // black, or nearly so, without corners and edges
  std::size_t plain() const { return plain_; }  // light enough, but without corners and edges
  // For people, a line each: of more than one image in twenty.
  std::vector<std::string> Problems() const;

 private:
  std::size_t count_ = 0, dark_ = 0, plain_ = 0;
};

}  // namespace highwall::apps
