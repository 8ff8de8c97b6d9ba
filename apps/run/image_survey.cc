#include "run/image_survey.h"

#include <opencv2/imgproc.hpp>

#include <fmt/core.h>

namespace highwall::apps {
namespace {

// [grey levels] kStep: minimum contrast of a corner (frame.orb.min_fast_threshold). kDark: mean of
// an image that is too dark for corners, three times as much, as for LossReason::kDark.
constexpr double kStep = 7.0, kDark = 21.0;
// Share of the pixels, less than an edge a few pixels wide over a third of the image's width.
constexpr double kLeastShare = 0.002;

// Returns the share of pixels that differ from the pixel two to the right or two below. 3 x 3 means
// prevent noise from counting as texture.
double ShareOfSteps(const cv::Mat& gray) {
  constexpr int kApart = 2;
  if (gray.cols <= kApart || gray.rows <= kApart) return 0.0;
  cv::Mat smooth, steps;
  cv::blur(gray, smooth, {3, 3});
  const cv::Rect here(0, 0, gray.cols - kApart, gray.rows - kApart);
  cv::Mat right, below;
  cv::absdiff(smooth(here), smooth(here + cv::Point(kApart, 0)), right);
  cv::absdiff(smooth(here), smooth(here + cv::Point(0, kApart)), below);
  cv::max(right, below, steps);
  return static_cast<double>(cv::countNonZero(steps >= kStep)) / static_cast<double>(steps.total());
}

}  // namespace

void ImageSurvey::Add(const cv::Mat& bgr) {
  cv::Mat gray;
  cv::cvtColor(bgr, gray, cv::COLOR_BGR2GRAY);
  ++count_;
  if (ShareOfSteps(gray) >= kLeastShare) return;
  ++(cv::mean(gray)[0] < kDark ? dark_ : plain_);
}

std::vector<std::string> ImageSurvey::Problems() const {
  std::vector<std::string> problems;
  const auto add = [&](std::size_t images, const char* what) {
    if (20 * images <= count_) return;
    problems.push_back(fmt::format("{} of {} colour images {}", images, count_, what));
  };
  add(dark_,
      "are black or too dark to find features in: more light, a longer exposure, or a lens that is "
      "not covered");
  add(plain_, "show hardly any texture: nothing with corners or edges can be tracked in them");
  return problems;
}

}  // namespace highwall::apps
