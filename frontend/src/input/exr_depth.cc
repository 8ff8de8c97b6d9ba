#include "input/exr_depth.h"

#include <cmath>
#include <cstdint>
#include <exception>
#include <string>

#include <ImathBox.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>

namespace highwall {
namespace {

// Returns the name of the channel with the depth; null if there is none.
const char* DepthChannel(const Imf::ChannelList& channels) {
  for (const char* const name : {"Y", "Z", "R"}) {
    const Imf::Channel* const channel = channels.findChannel(name);
    if (channel != nullptr && channel->xSampling == 1 && channel->ySampling == 1) return name;
  }
  return nullptr;
}

cv::Mat ReadChannel(const std::filesystem::path& path) {
  constexpr std::int64_t kMost = 16384;  // [px] of a side: more is damage
  Imf::InputFile file(path.string().c_str(), 0);
  const Imath::Box2i window = file.header().dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
  if (width < 1 || height < 1 || width > kMost || height > kMost) {
    throw IoError(path, "is damaged: its size is impossible");
  }
  const char* const channel = DepthChannel(file.header().channels());
  if (channel == nullptr) throw IoError(path, "has no channel Y, Z or R with depth");
  cv::Mat depth = cv::Mat::zeros(static_cast<int>(height), static_cast<int>(width), CV_32FC1);
  Imf::FrameBuffer buffer;
  buffer.insert(channel, Imf::Slice::Make(Imf::FLOAT, depth.ptr<float>(), window, sizeof(float),
                                          depth.step[0]));
  file.setFrameBuffer(buffer);
  file.readPixels(window.min.y, window.max.y);
  return depth;
}

}  // namespace

cv::Mat ReadExrDepth(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) throw IoError(path, "is missing");
  cv::Mat depth;
  try {
    depth = ReadChannel(path);
  } catch (const IoError&) {
    throw;
  } catch (const std::exception&) {  // its message names the library's own functions
    throw IoError(path, "is no OpenEXR image, or is truncated or damaged");
  }
  for (int v = 0; v < depth.rows; ++v) {
    float* const z = depth.ptr<float>(v);
    for (int u = 0; u < depth.cols; ++u) {
      if (!(z[u] > 0.0F) || !std::isfinite(z[u])) z[u] = 0.0F;
    }
  }
  return depth;
}

}  // namespace highwall
