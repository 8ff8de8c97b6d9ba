#include <highwall/frontend/input/repeated_image.h>

#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>

namespace highwall::repeated_image_test {
namespace {

// Returns rectangles of all sizes and colours, shifted by a fraction of a pixel, with the noise of
// a sensor.
cv::Mat Scene(const cv::Size& size, double shift = 0.0, double noise = 0.0,
              std::uint64_t seed = 1) {
  cv::RNG rng(5);
  cv::Mat image(size, CV_8UC3, cv::Scalar(110, 120, 130));
  for (int i = 0; i < 150; ++i) {
    const cv::Point corner(rng.uniform(0, size.width), rng.uniform(0, size.height));
    const cv::Size extent(rng.uniform(size.width / 40, size.width / 6),
                          rng.uniform(size.height / 40, size.height / 6));
    const cv::Scalar colour(rng.uniform(20, 230), rng.uniform(20, 230), rng.uniform(20, 230));
    cv::rectangle(image, cv::Rect(corner, extent), colour, cv::FILLED);
  }
  cv::GaussianBlur(image, image, {}, 1.0);
  const cv::Matx23d move(1.0, 0.0, shift, 0.0, 1.0, 0.0);
  cv::warpAffine(image, image, move, size, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  if (noise > 0.0) {
    cv::RNG grain(seed);
    cv::Mat noisy(size, CV_32FC3);
    grain.fill(noisy, cv::RNG::NORMAL, 0.0, noise);
    cv::add(image, noisy, image, cv::noArray(), CV_8U);
  }
  return image;
}

cv::Mat CodedAnew(const cv::Mat& image, int quality) {
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
  return cv::imdecode(bytes, cv::IMREAD_COLOR);
}

bool Repeats(const cv::Mat& first, const cv::Mat& second) {
  RepeatedImage repeated;
  EXPECT_FALSE(repeated.Update(first)) << "the first repeats nothing";
  return repeated.Update(second);
}

const std::vector<cv::Size> kSizes{{640, 480}, {1280, 720}, {320, 240}, {480, 640}, {160, 120}};

TEST(RepeatedImage, TheSameBytesRepeat) {
  for (const cv::Size& size : kSizes) {
    const cv::Mat image = Scene(size, 0.0, 1.5);
    EXPECT_TRUE(Repeats(image, image.clone())) << size;
  }
}

TEST(RepeatedImage, TheSameImageCodedAnewRepeats) {
  for (const cv::Size& size : kSizes) {
    const cv::Mat image = CodedAnew(Scene(size, 0.0, 1.5), 95);
    for (const int quality : {98, 95}) {
      EXPECT_TRUE(Repeats(image, CodedAnew(image, quality))) << size << " at " << quality;
    }
  }
}

// Colour channels have independent noise: one grey level in each is 0.6 in the mean of three.
TEST(RepeatedImage, ACameraThatStandsStillDoesNotRepeat) {
  for (const cv::Size& size : kSizes) {
    for (const double noise : {1.0, 2.0, 4.0}) {
      const cv::Mat first = Scene(size, 0.0, noise, 1), second = Scene(size, 0.0, noise, 2);
      EXPECT_FALSE(Repeats(first, second)) << size << ", noise " << noise;
      EXPECT_FALSE(Repeats(CodedAnew(first, 92), CodedAnew(second, 92))) << size << ", as JPEG";
    }
  }
}

TEST(RepeatedImage, AMovedCameraWithoutNoiseDoesNotRepeat) {
  for (const cv::Size& size : kSizes) {
    EXPECT_FALSE(Repeats(Scene(size), Scene(size, 0.5))) << size;
  }
}

TEST(RepeatedImage, SeesMotionBeforeACameraWithoutNoise) {
  for (const cv::Size& size : kSizes) {
    const cv::Mat first = Scene(size);
    cv::Mat second = first.clone();
    const cv::Rect ball(size.width / 2, size.height / 2, size.width / 12, size.height / 12);
    second(ball).setTo(cv::Scalar(0, 0, 255));
    EXPECT_FALSE(Repeats(first, second)) << size;
  }
}

// Dark images are similar although they are new: they contain no information.
TEST(RepeatedImage, ACoveredLensDoesNotRepeat) {
  const cv::Size size(640, 480);
  const cv::Mat black(size, CV_8UC3, cv::Scalar::all(0));
  EXPECT_FALSE(Repeats(black, black.clone()));
  cv::Mat first = black.clone(), second = black.clone();
  cv::RNG rng(3);
  for (cv::Mat* image : {&first, &second}) {
    cv::Mat grain(size, CV_32FC3);
    rng.fill(grain, cv::RNG::NORMAL, 0.0, 0.7);
    cv::add(*image, grain, *image, cv::noArray(), CV_8U);
  }
  EXPECT_FALSE(Repeats(first, second));
}

TEST(RepeatedImage, ComparesWithTheLastImageOnly) {
  const cv::Size size(640, 480);
  const cv::Mat a = Scene(size, 0.0, 2.0, 1), b = Scene(size, 3.0, 2.0, 2);
  RepeatedImage repeated;
  EXPECT_FALSE(repeated.Update(a));
  EXPECT_FALSE(repeated.Update(b));
  EXPECT_TRUE(repeated.Update(b.clone()));
  EXPECT_TRUE(repeated.Update(b.clone()));
  EXPECT_FALSE(repeated.Update(a));
  EXPECT_FALSE(repeated.Update(Scene({320, 240}, 0.0, 2.0, 1))) << "of another size";
}

TEST(RepeatedImage, RefusesImagesThatAreNotInColour) {
  RepeatedImage repeated;
  EXPECT_THROW(repeated.Update(cv::Mat(48, 64, CV_8UC1)), InvalidArgument);
  EXPECT_FALSE(repeated.Update(cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(9))));
  EXPECT_FALSE(repeated.Update(cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(9)))) << "no inner pixel";
}

}  // namespace
}  // namespace highwall::repeated_image_test
