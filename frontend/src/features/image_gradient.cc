#include "features/image_gradient.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace highwall::internal {

namespace {

constexpr int kBlurReach = 2;  // [px] of the blur to each side

// Blurs a row, padded by kBlurReach pixels at each end, by the binomial weights (1 4 6 4 1), whose
// sum is 16.
void BlurAlong(const std::uint8_t* padded, int width, std::uint16_t* blurred) {
  for (int x = 0; x < width; ++x) {
    const std::uint8_t* p = padded + x;
    blurred[x] = static_cast<std::uint16_t>(p[0] + p[4] + 4 * (p[1] + p[3]) + 6 * p[2]);
  }
}

// The same over five rows, divided by 16: up to 16 x 255.
void BlurAcross(const std::array<const std::uint16_t*, 5>& rows, int width, std::int16_t* blurred) {
  const std::uint16_t *r0 = rows[0], *r1 = rows[1], *r2 = rows[2], *r3 = rows[3], *r4 = rows[4];
  for (int x = 0; x < width; ++x) {
    const auto sum =
        static_cast<std::uint16_t>(r0[x] + r4[x] + 4 * (r1[x] + r3[x]) + 6 * r2[x] + 8);
    blurred[x] = static_cast<std::int16_t>(sum >> 4);
  }
}

// Sobel derivatives of the middle one of three rows, padded by a pixel at each end.
void Differentiate(const std::int16_t* above, const std::int16_t* row, const std::int16_t* below,
                   int width, std::int16_t* gradient) {
  for (int x = 0; x < width; ++x) {
    const std::int16_t *a = above + x, *b = row + x, *c = below + x;
    gradient[2 * x] = static_cast<std::int16_t>((a[2] - a[0]) + 2 * (b[2] - b[0]) + (c[2] - c[0]));
    gradient[2 * x + 1] =
        static_cast<std::int16_t>((c[0] - a[0]) + 2 * (c[1] - a[1]) + (c[2] - a[2]));
  }
}

}  // namespace

void ImageGradient::Compute(const cv::Mat& gray) {
  gradient_.create(gray.size(), CV_16SC2);
  const int width = gray.cols, last = gray.rows - 1;
  const auto size = static_cast<std::size_t>(width);
  std::vector<std::uint8_t> padded(size + 2 * kBlurReach);
  std::array<std::vector<std::uint16_t>, 5> along;   // row v at v modulo 5
  std::array<std::vector<std::int16_t>, 3> blurred;  // padded; row v at v modulo 3
  for (auto& row : along) row.resize(size);
  for (auto& row : blurred) row.resize(size + 2);
  const auto blur_along = [&](int v) {
    const std::uint8_t* row = gray.ptr<std::uint8_t>(v);
    std::fill_n(padded.begin(), kBlurReach, row[0]);
    std::copy_n(row, size, padded.begin() + kBlurReach);
    std::fill_n(padded.end() - kBlurReach, kBlurReach, row[width - 1]);
    BlurAlong(padded.data(), width, along[static_cast<std::size_t>(v % 5)].data());
  };
  const auto blur = [&](int v) {
    std::array<const std::uint16_t*, 5> rows;
    for (int i = 0; i < 5; ++i) {
      const int u = std::clamp(v + i - kBlurReach, 0, last);
      rows[static_cast<std::size_t>(i)] = along[static_cast<std::size_t>(u % 5)].data();
    }
    std::vector<std::int16_t>& row = blurred[static_cast<std::size_t>(v % 3)];
    BlurAcross(rows, width, row.data() + 1);
    row.front() = row[1];
    row.back() = row[size];
  };
  for (int v = 0; v <= std::min(kBlurReach, last); ++v) blur_along(v);
  blur(0);
  for (int v = 0; v <= last; ++v) {
    if (v + 3 <= last) blur_along(v + 3);
    if (v + 1 <= last) blur(v + 1);
    const auto row = [&](int u) {
      return blurred[static_cast<std::size_t>(std::clamp(u, 0, last) % 3)].data();
    };
    Differentiate(row(v - 1), row(v), row(v + 1), width, gradient_.ptr<std::int16_t>(v));
  }
}

}  // namespace highwall::internal
