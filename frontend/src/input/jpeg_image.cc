#include "input/jpeg_image.h"

#include <turbojpeg.h>

#include <memory>
#include <type_traits>

namespace highwall {

bool IsJpeg(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= 3 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF;
}

std::optional<JpegImage> DecodeJpeg(std::span<const std::uint8_t> bytes) {
  const std::unique_ptr<std::remove_pointer_t<tjhandle>, decltype(&tjDestroy)> decoder(
      tjInitDecompress(), &tjDestroy);
  if (!decoder) return std::nullopt;
  int width = 0, height = 0, sampling = 0, colours = 0;
  if (tjDecompressHeader3(decoder.get(), bytes.data(), bytes.size(), &width, &height, &sampling,
                          &colours) != 0 ||
      width <= 0 || height <= 0) {
    return std::nullopt;
  }
  if (colours != TJCS_GRAY && colours != TJCS_YCbCr && colours != TJCS_RGB) return std::nullopt;
  const bool grey = colours == TJCS_GRAY;
  JpegImage image;
  image.pixels.create(height, width, grey ? CV_8UC1 : CV_8UC3);
  if (tjDecompress2(decoder.get(), bytes.data(), bytes.size(), image.pixels.data, width,
                    static_cast<int>(image.pixels.step), height, grey ? TJPF_GRAY : TJPF_BGR,
                    0) != 0) {
    if (tjGetErrorCode(decoder.get()) != TJERR_WARNING) return std::nullopt;
    image.has_warnings = true;
  }
  return image;
}

}  // namespace highwall
