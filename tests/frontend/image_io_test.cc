#include <highwall/frontend/input/image_io.h>

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include <highwall/core/error.h>

#include "support/message_of.h"
#include "support/temporary_directory.h"

namespace highwall::image_io_test {
namespace {

cv::Mat RandomImage(int type) {
  cv::Mat image(31, 45, type);
  cv::RNG random(3);
  random.fill(image, cv::RNG::UNIFORM, 0, CV_MAT_DEPTH(type) == CV_16U ? 60000 : 256);
  return image;
}

std::string TypeOf(const cv::Mat& image) { return cv::typeToString(image.type()); }

// Formats that are decoded directly, and those of the module highwall_media.
TEST(ImageIo, EqualsOpenCvForEveryFormat) {
  const testing::TemporaryDirectory folder;
  for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1, CV_16UC3}) {
    for (const std::string format : {".png", ".jpg", ".bmp", ".tiff", ".pgm", ".ppm"}) {
      const bool eight = CV_MAT_DEPTH(type) == CV_8U, grey = CV_MAT_CN(type) == 1;
      if (!eight && (format == ".jpg" || format == ".bmp")) continue;
      if (format == ".pgm" && !grey) continue;
      if (format == ".ppm" && CV_MAT_CN(type) != 3) continue;
      const auto path = folder / ("image" + format);
      ASSERT_TRUE(cv::imwrite(path.string(), RandomImage(type)));
      struct Case {
        cv::Mat read;
        int flags;
      };
      for (const Case& c : {Case{ReadStoredImage(path), cv::IMREAD_UNCHANGED},
                            Case{ReadColourImage(path), cv::IMREAD_COLOR},
                            Case{ReadGreyImage(path), cv::IMREAD_GRAYSCALE}}) {
        const cv::Mat expected = cv::imread(path.string(), c.flags);
        ASSERT_EQ(TypeOf(c.read), TypeOf(expected)) << format;
        EXPECT_EQ(cv::norm(c.read, expected, cv::NORM_INF), 0.0) << format << TypeOf(c.read);
      }
    }
  }
}

TEST(ImageIo, NamesAFileThatIsNoImage) {
  const testing::TemporaryDirectory folder;
  const auto path = folder / "image.png";
  std::ofstream(path) << "not an image";
  EXPECT_EQ(testing::MessageOf<IoError>([&] { ReadColourImage(path); }),
            path.string() + ": is not an image or is damaged");
}

}  // namespace
}  // namespace highwall::image_io_test
