#include "input/video_frames.h"

#include <string>
#include <system_error>
#include <utility>

#include <highwall/core/error.h>

#include "input/media_module.h"

namespace highwall {

VideoFrames::VideoFrames(std::filesystem::path path) : path_(std::move(path)) {
  Open();
}

void VideoFrames::Open() {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path_, error)) throw IoError(path_, "is missing");
  decoder_ = MediaFor(path_).open_video(path_);
  if (!decoder_) {
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
    if (!decoder_->Skip()) break;
  }
  const cv::Mat image = next_ == index ? decoder_->Next() : cv::Mat();
  if (image.type() != CV_8UC3 || image.empty()) {
    const std::string count = std::to_string(next_);
    throw IoError(path_, "has no image " + std::to_string(index) + ": it ends after " + count);
  }
  ++next_;
  last_ = image;
  return image.clone();
}

}  // namespace highwall
