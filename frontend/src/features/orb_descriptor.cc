#include "features/orb_descriptor.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <vector>

#include <highwall/internal/target_clones.h>

#include "features/orb_pattern.h"

namespace highwall::internal {
namespace {

constexpr int kTests = static_cast<int>(kOrbPattern.size());
constexpr int kReach = 19;            // [px] of a rotated test, rounded up
constexpr int kMargin = kReach - 17;  // [px] around the image that tests may reach
constexpr std::array<std::uint16_t, 4> kGauss = {54, 49, 34, 18};  // of 256: sigma 2 px, 7 taps
constexpr int kTaps = 7, kRadius = kTaps / 2;

// The pixels of all tests, first and second in turn.
struct TestedPixels {
  std::array<float, 2 * kTests> x{}, y{};
};
constexpr TestedPixels kTested = [] {
  TestedPixels tested;
  for (std::size_t i = 0; i < kOrbPattern.size(); ++i) {
    for (std::size_t j = 0; j < 2; ++j) {
      tested.x[2 * i + j] = kOrbPattern[i][2 * j];
      tested.y[2 * i + j] = kOrbPattern[i][2 * j + 1];
    }
  }
  return tested;
}();

// Smooths a row of count + 6 pixels; the sums are in 256ths of a grey level.
HIGHWALL_TARGET_CLONES("avx2", "default")
void SmoothRow(const std::uint8_t* row, int count, std::uint16_t* sums) {
  for (int i = 0; i < count; ++i) {
    const std::uint8_t* c = row + i + kRadius;
    sums[i] = static_cast<std::uint16_t>(kGauss[0] * c[0] + kGauss[1] * (c[-1] + c[1]) +
                                         kGauss[2] * (c[-2] + c[2]) + kGauss[3] * (c[-3] + c[3]));
  }
}

// Returns the product with a weight, in 256ths of a grey level, rounded down.
[[gnu::always_inline]] inline std::uint16_t Weighted(std::uint16_t sum, std::uint16_t weight) {
  return static_cast<std::uint16_t>((std::uint32_t{sum} * (std::uint32_t{weight} << 8)) >> 16);
}

// Smooths across seven rows of sums.
HIGHWALL_TARGET_CLONES("avx2", "default")
void SmoothColumn(const std::array<const std::uint16_t*, kTaps>& rows, int count,
                  std::uint8_t* smooth) {
  // Half a grey level, and half of what rounding down can take from each of seven products.
  constexpr std::uint16_t kHalf = 128 + kTaps / 2;
  const std::uint16_t *a = rows[0], *b = rows[1], *c = rows[2], *d = rows[3], *e = rows[4],
                      *f = rows[5], *g = rows[6];
  for (int i = 0; i < count; ++i) {
    const auto sum = static_cast<std::uint16_t>(
        Weighted(d[i], kGauss[0]) + Weighted(c[i], kGauss[1]) + Weighted(e[i], kGauss[1]) +
        Weighted(b[i], kGauss[2]) + Weighted(f[i], kGauss[2]) + Weighted(a[i], kGauss[3]) +
        Weighted(g[i], kGauss[3]) + kHalf);
    smooth[i] = static_cast<std::uint8_t>(sum >> 8);
  }
}

// Returns the index of a pixel beyond the edge, mirrored at the outermost pixel.
int Mirrored(int i, int size) {
  return i < 0 ? -i : i < size ? i : 2 * size - 2 - i;
}

// Returns the image smoothed by a Gaussian of 2 px, with kMargin pixels more on each side.
cv::Mat Smoothed(const cv::Mat& image) {
  constexpr int kPad = kMargin + kRadius;
  const int width = image.cols + 2 * kMargin;
  const auto stride = static_cast<std::size_t>(width);
  std::vector<std::uint8_t> padded(static_cast<std::size_t>(image.cols + 2 * kPad));
  std::vector<std::uint16_t> sums(kTaps * stride);  // of the last seven rows, in turn
  const auto sums_of = [&](int y) {
    return sums.data() + static_cast<std::size_t>((y + kPad) % kTaps) * stride;
  };
  cv::Mat smooth(image.rows + 2 * kMargin, width, CV_8UC1);
  for (int y = -kPad; y < image.rows + kPad; ++y) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(Mirrored(y, image.rows));
    std::memcpy(padded.data() + kPad, row, static_cast<std::size_t>(image.cols));
    for (int i = 1; i <= kPad; ++i) {
      padded[static_cast<std::size_t>(kPad - i)] = row[i];
      padded[static_cast<std::size_t>(kPad + image.cols - 1 + i)] = row[image.cols - 1 - i];
    }
    SmoothRow(padded.data(), width, sums_of(y));
    const int centre = y - kRadius;
    if (centre < -kMargin) continue;
    std::array<const std::uint16_t*, kTaps> rows{};
    for (int i = 0; i < kTaps; ++i) {
      rows[static_cast<std::size_t>(i)] = sums_of(centre + i - kRadius);
    }
    SmoothColumn(rows, width, smooth.ptr<std::uint8_t>(centre + kMargin));
  }
  return smooth;
}

// Rotates the tests and returns their pixels as offsets from the corner's.
HIGHWALL_TARGET_CLONES("avx2", "default")
void RotateTests(float cosine, float sine, int stride, int* offsets) {
  // Makes coordinates positive, because truncation rounds only positive numbers down.
  constexpr float kRounding = kReach + 0.5F;
  for (std::size_t i = 0; i < 2 * kTests; ++i) {
    const float x = kTested.x[i] * cosine - kTested.y[i] * sine;
    const float y = kTested.x[i] * sine + kTested.y[i] * cosine;
    offsets[i] = (static_cast<int>(y + kRounding) - kReach) * stride +
                 static_cast<int>(x + kRounding) - kReach;
  }
}

void RunTests(const std::uint8_t* corner, const int* offsets, std::uint8_t* descriptor) {
  for (int byte = 0; byte < kTests / 8; ++byte, offsets += 16) {
    int bits = 0;
    for (int bit = 0; bit < 8; ++bit) {
      bits |= (corner[offsets[2 * bit]] < corner[offsets[2 * bit + 1]]) << bit;
    }
    descriptor[byte] = static_cast<std::uint8_t>(bits);
  }
}

}  // namespace

cv::Mat DescribeOrb(const cv::Mat& image, std::span<const cv::KeyPoint> corners) {
  cv::Mat descriptors(static_cast<int>(corners.size()), kTests / 8, CV_8UC1);
  if (corners.empty()) return descriptors;
  const cv::Mat smooth = Smoothed(image);
  std::array<int, 2 * kTests> offsets;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const cv::KeyPoint& corner = corners[i];
    const float angle = corner.angle * std::numbers::pi_v<float> / 180.0F;
    RotateTests(std::cos(angle), std::sin(angle), static_cast<int>(smooth.step[0]), offsets.data());
    RunTests(
        smooth.ptr<std::uint8_t>(cvRound(corner.pt.y) + kMargin) + cvRound(corner.pt.x) + kMargin,
        offsets.data(), descriptors.ptr<std::uint8_t>(static_cast<int>(i)));
  }
  return descriptors;
}

}  // namespace highwall::internal
