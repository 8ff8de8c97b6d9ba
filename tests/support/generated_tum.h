#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "support/temporary_directory.h"

// Small TUM RGB-D datasets for tests.
namespace highwall::testing {

struct GeneratedTum {
  int frames = 6;                  // <= 10
  int width = 64, height = 48;     // [px]
  std::uint16_t raw_depth = 5000;  // for all pixels except those of the first column, which are 0
  bool textured = false;           // noise in the colour image instead of a constant
  int depth_step = 0;              // depth varies by so much, up and down twice, as if measured
};

inline std::string FrameName(int frame) {
  return std::to_string(100 + frame);
}

inline cv::Mat DepthOf(const GeneratedTum& tum, int frame) {
  cv::Mat raw(tum.height, tum.width, CV_16UC1, cv::Scalar(tum.raw_depth));
  for (int v = 0; v < raw.rows; ++v) {
    for (int u = 0; u < raw.cols; ++u) {
      const int steps = (u + 2 * v + frame) % 5 - 2;
      raw.at<std::uint16_t>(v, u) =
          static_cast<std::uint16_t>(tum.raw_depth + steps * tum.depth_step);
    }
  }
  raw.col(0).setTo(0);
  return raw;
}

// Colour stamps 100.00, 100.10, ...; depth 5 ms later; frame i is filled with the colour (i, 2, 3).
inline void WriteTum(const std::filesystem::path& directory, const GeneratedTum& tum = {}) {
  std::filesystem::create_directories(directory / "rgb");
  std::filesystem::create_directories(directory / "depth");
  std::string rgb = "# color images\n", depth = "# depth maps\n";
  for (int i = 0; i < tum.frames; ++i) {
    const std::string file = FrameName(i) + ".png";
    const cv::Mat raw = DepthOf(tum, i);
    cv::Mat colour(tum.height, tum.width, CV_8UC3, cv::Scalar(i, 2, 3));
    if (tum.textured)
      cv::RNG(static_cast<std::uint64_t>(i) + 1).fill(colour, cv::RNG::UNIFORM, 0, 255);
    cv::imwrite((directory / "rgb" / file).string(), colour);
    cv::imwrite((directory / "depth" / file).string(), raw);
    rgb += "100." + std::to_string(i) + "00 rgb/" + file + "\n";
    depth += "100." + std::to_string(i) + "05 depth/" + file + "\n";
  }
  WriteText(directory / "rgb.txt", rgb);
  WriteText(directory / "depth.txt", depth);
}

// Truncates the file to the first `share` of its size.
inline void Truncate(const std::filesystem::path& path, double share = 0.5) {
  const double size = static_cast<double>(std::filesystem::file_size(path));
  std::filesystem::resize_file(path, static_cast<std::uintmax_t>(size * share));
}

}  // namespace highwall::testing
