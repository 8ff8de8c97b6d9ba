#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/internal/require.h>
#include <highwall/internal/target_clones.h>

namespace highwall {
namespace {

// Corrects a depth [m] whose inverse is too large by `offset` [1/m].
inline float Corrected(float z, double offset) {
  const double rest = 1.0 - offset * static_cast<double>(z);
  const auto corrected = static_cast<float>(static_cast<double>(z) / rest);
  // A conditional expression would keep a loop over a row from being vectorized, because the
  // quotient could no longer be computed for all pixels.
  const std::uint32_t mask = 0U - static_cast<std::uint32_t>(rest > 0.0);
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(corrected) & mask);
}

// Corrects readings between two columns of nodes, of these distortions [1/m]. shares: of the right
// one in each reading. Clones: AVX2 without FMA, so that both round identically.
HIGHWALL_TARGET_CLONES("avx2", "default")
void CorrectBetween(double left, double right, const double* __restrict shares, std::size_t count,
                    float* __restrict row) {
  for (std::size_t u = 0; u < count; ++u) {
    row[u] = Corrected(row[u], (1.0 - shares[u]) * left + shares[u] * right);
  }
}

// Subtracts an offset and a pattern from the inverse depths of an image: between the columns of
// nodes the pattern is linear along a row.
class PatternRemover {
 public:
  PatternRemover(double offset, const DepthPattern& pattern, cv::Mat* depth)
      : offset_(offset),
        pattern_(pattern),
        depth_(*depth),
        step_((depth->cols - 1) / (kNodes - 1.0)),
        shares_(static_cast<std::size_t>(depth->cols)) {
    ends_.fill(0);
    for (std::size_t u = 0; u < shares_.size(); ++u) {
      const double x = step_ > 0.0 ? static_cast<double>(u) / step_ : 0.0;
      const std::size_t left = std::min(static_cast<std::size_t>(x), kNodes - 2);
      shares_[u] = x - static_cast<double>(left);
      for (std::size_t i = left; i < ends_.size(); ++i) ends_[i] = u + 1;
    }
  }

  void CorrectRow(int v) {
    std::array<double, kNodes> at_nodes{};  // [1/m]
    for (std::size_t i = 0; i < at_nodes.size(); ++i) {
      at_nodes[i] =
          offset_ + pattern_.At(static_cast<double>(i) * step_, v, depth_.cols, depth_.rows);
    }
    auto* const row = depth_.ptr<float>(v);
    std::size_t u = 0;
    for (std::size_t i = 0; i < ends_.size(); ++i) {
      CorrectBetween(at_nodes[i], at_nodes[i + 1], shares_.data() + u, ends_[i] - u, row + u);
      u = ends_[i];
    }
  }

 private:
  static constexpr std::size_t kNodes = DepthPattern::kColumns;

  const double offset_;
  const DepthPattern& pattern_;
  cv::Mat& depth_;
  const double step_;                         // [px] from a node to the next
  std::vector<double> shares_;                // of the right node, for each column
  std::array<std::size_t, kNodes - 1> ends_;  // columns where the next pair of nodes begins
};

}  // namespace

cv::Mat MetricDepth(const cv::Mat& stored, double depth_factor, double inverse_depth_offset,
                    const DepthPattern& pattern) {
  HIGHWALL_REQUIRE(stored.type() == CV_16UC1 || stored.type() == CV_32FC1,
                   "MetricDepth: the image must be CV_16UC1 or CV_32FC1");
  RequirePositiveFinite(depth_factor, "MetricDepth: depth_factor");
  HIGHWALL_REQUIRE(std::isfinite(inverse_depth_offset),
                   "MetricDepth: inverse_depth_offset must be finite");
  pattern.Validate();
  cv::Mat depth;
  stored.convertTo(depth, CV_32F, 1.0 / depth_factor);
  if (!pattern.IsZero()) {
    PatternRemover remover(inverse_depth_offset, pattern, &depth);
    for (int v = 0; v < depth.rows; ++v) remover.CorrectRow(v);
  } else if (inverse_depth_offset != 0.0) {
    depth.forEach<float>(
        [inverse_depth_offset](float& z, const int*) { z = Corrected(z, inverse_depth_offset); });
  }
  return depth;
}

}  // namespace highwall
