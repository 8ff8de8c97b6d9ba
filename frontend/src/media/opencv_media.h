#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include <opencv2/core/mat.hpp>

// What the module highwall_media offers to input/media_module.h, which loads it.
namespace highwall {

class VideoDecoder {
 public:
  virtual ~VideoDecoder() = default;
  // Skips an image. Returns false at the end.
  virtual bool Skip() = 0;
  // Decodes the next image as stored, not turned by orientation tags. Returns an empty one at the end.
  virtual cv::Mat Next() = 0;
};

struct OpenCvMedia {
  // cv::imdecode. mode: of cv::ImreadModes. An exception of OpenCV goes to problem.
  cv::Mat (*decode_image)(std::span<const std::uint8_t> bytes, int mode, std::string* problem);
  // Returns nullptr if the file is no video that OpenCV can decode.
  std::unique_ptr<VideoDecoder> (*open_video)(const std::filesystem::path& path);
};

// The name under which the module exports its only symbol, an OpenCvMedia.
inline constexpr const char* kMediaSymbol = "highwall_opencv_media";

}  // namespace highwall
