#include "input/video_frames.h"

#include <string>
#include <system_error>
#include <utility>

#include <highwall/core/error.h>

namespace highwall {

VideoFrames::VideoFrames(std::filesystem::path path) : path_(std::move(path)) {
  Open();
}

void VideoFrames::Open() {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path_, error)) throw IoError(path_, "is missing");
  try {
    capture_.open(path_.string());
    if (capture_.isOpened()) capture_.set(cv::CAP_PROP_ORIENTATION_AUTO, 0.0);
  } catch (const cv::Exception&) {  // its message names OpenCV's own sources
    capture_.release();
  }
  if (!capture_.isOpened()) {
    throw IoError(path_,
                  "is no video that OpenCV can decode; extract its images to the folder rgb");
  }
  next_ = 0;
  last_.release();
}

cv::Mat VideoFrames::Read(std::size_t index) {
  const std::scoped_lock lock(mutex_);
  if (index + 1 == next_ && !last_.empty()) return last_.clone();
  if (index < next_) Open();
  for (; next_ < index; ++next_) {
    if (!capture_.grab()) break;
  }
  cv::Mat image;
  if (next_ != index || !capture_.read(image) || image.type() != CV_8UC3) {
    const std::string count = std::to_string(next_);
    throw IoError(path_, "has no image " + std::to_string(index) + ": it ends after " + count);
  }
  ++next_;
  last_ = image;
  return image.clone();
}

}  // namespace highwall
