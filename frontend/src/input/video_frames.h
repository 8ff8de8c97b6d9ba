#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <mutex>

#include <opencv2/core/mat.hpp>

#include "media/opencv_media.h"

namespace highwall {

// The images of a video by their numbers. They are decoded one after the other, because the
// positions that players of videos compute from stamps are off by one where the intervals vary:
// reading in order is fast, and an earlier image starts again from the beginning.
class VideoFrames {
 public:
  // Throws IoError if the file is missing or no video that OpenCV can decode.
  explicit VideoFrames(std::filesystem::path path);

  // Returns the image with this number, from 0, as stored: CV_8UC3 BGR, not turned by orientation
  // tags. May be called from several threads. Throws IoError if the video ends before it.
  cv::Mat Read(std::size_t index);

  const std::filesystem::path& path() const { return path_; }

 private:
  void Open();

  std::filesystem::path path_;
  std::mutex mutex_;
  std::unique_ptr<VideoDecoder> decoder_;
  std::size_t next_ = 0;  // number of the image that is decoded next
  cv::Mat last_;          // the image before it, if any
};

}  // namespace highwall
