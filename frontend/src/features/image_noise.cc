#include "features/image_noise.h"

#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include <highwall/internal/median.h>

namespace highwall::internal {

double NoiseSigma(const cv::Mat& gray) {
  constexpr int kRowStep = 4, kColumnStep = 2;  // enough for a median
  constexpr double kMaskNorm = 6.0;             // norm of the mask
  constexpr double kMedianOverSigma = 0.6745;   // of |x| of a normal distribution
  std::vector<int> residuals;
  for (int v = 1; v + 1 < gray.rows; v += kRowStep) {
    const std::uint8_t* above = gray.ptr<std::uint8_t>(v - 1);
    const std::uint8_t* row = gray.ptr<std::uint8_t>(v);
    const std::uint8_t* below = gray.ptr<std::uint8_t>(v + 1);
    const auto bend = [](const std::uint8_t* p) { return p[-1] - 2 * p[0] + p[1]; };
    for (int u = 1; u + 1 < gray.cols; u += kColumnStep) {
      if (row[u] == 0 || row[u] == 255) continue;
      residuals.push_back(std::abs(bend(above + u) - 2 * bend(row + u) + bend(below + u)));
    }
  }
  if (residuals.empty()) return 0.0;
  return UpperMedian(std::move(residuals)) / (kMaskNorm * kMedianOverSigma);
}

}  // namespace highwall::internal
