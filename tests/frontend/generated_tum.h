#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include <unistd.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include <gtest/gtest.h>

// Small TUM RGB-D datasets for tests, in a folder that goes with the object.
namespace highwall::testing {

class TemporaryDirectory {
 public:
  explicit TemporaryDirectory(const std::string& name = "") {
    const ::testing::TestInfo* test = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::temp_directory_path() /
            ("highwall_" + std::to_string(::getpid()) + "_" + test->test_suite_name() + "_" +
             test->name() + name);
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~TemporaryDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline void WriteText(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

struct GeneratedTum {
  int frames = 6;                  // <= 10
  int width = 64, height = 48;     // [px]
  std::uint16_t raw_depth = 5000;  // of every pixel but the first column, which is 0
};

inline std::string FrameName(int frame) {
  return std::to_string(100 + frame);
}

// Colour stamps 100.00, 100.10, ...; depth 5 ms later; frame i is filled with the colour (i, 2, 3).
inline void WriteTum(const std::filesystem::path& directory, const GeneratedTum& tum = {}) {
  std::filesystem::create_directories(directory / "rgb");
  std::filesystem::create_directories(directory / "depth");
  std::string rgb = "# color images\n", depth = "# depth maps\n";
  cv::Mat raw(tum.height, tum.width, CV_16UC1, cv::Scalar(tum.raw_depth));
  raw.col(0).setTo(0);
  for (int i = 0; i < tum.frames; ++i) {
    const std::string file = FrameName(i) + ".png";
    cv::imwrite((directory / "rgb" / file).string(),
                cv::Mat(tum.height, tum.width, CV_8UC3, cv::Scalar(i, 2, 3)));
    cv::imwrite((directory / "depth" / file).string(), raw);
    rgb += "100." + std::to_string(i) + "00 rgb/" + file + "\n";
    depth += "100." + std::to_string(i) + "05 depth/" + file + "\n";
  }
  WriteText(directory / "rgb.txt", rgb);
  WriteText(directory / "depth.txt", depth);
}

// Keeps the first `share` of the file.
inline void Truncate(const std::filesystem::path& path, double share = 0.5) {
  const double size = static_cast<double>(std::filesystem::file_size(path));
  std::filesystem::resize_file(path, static_cast<std::uintmax_t>(size * share));
}

}  // namespace highwall::testing
