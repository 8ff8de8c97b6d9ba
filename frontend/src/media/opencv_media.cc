// The module highwall_media: images of rare formats and videos, by OpenCV.
#include "media/opencv_media.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

namespace highwall {
namespace {

cv::Mat DecodeImage(std::span<const std::uint8_t> bytes, int mode, std::string* problem) {
  try {
    // imdecode does not write to its input.
    const cv::Mat wrapped(1, static_cast<int>(bytes.size()), CV_8UC1,
                          const_cast<std::uint8_t*>(bytes.data()));
    return cv::imdecode(wrapped, mode);
  } catch (const cv::Exception& error) {
    *problem = error.err;
    return {};
  }
}

class OpenCvVideo : public VideoDecoder {
 public:
  explicit OpenCvVideo(const std::filesystem::path& path) : capture_(path.string()) {
    if (capture_.isOpened()) capture_.set(cv::CAP_PROP_ORIENTATION_AUTO, 0.0);
  }

  bool IsOpen() const { return capture_.isOpened(); }
  bool Skip() override { return capture_.grab(); }

  cv::Mat Next() override {
    cv::Mat image;
    capture_.read(image);
    return image.clone();  // the capture writes its next image to the same memory
  }

 private:
  cv::VideoCapture capture_;
};

std::unique_ptr<VideoDecoder> OpenVideo(const std::filesystem::path& path) {
  try {
    auto video = std::make_unique<OpenCvVideo>(path);
    if (video->IsOpen()) return video;
  } catch (const cv::Exception&) {  // its message names OpenCV's own sources
  }
  return nullptr;
}

}  // namespace
}  // namespace highwall

extern "C" const highwall::OpenCvMedia highwall_opencv_media{
    &highwall::DecodeImage, &highwall::OpenVideo};
