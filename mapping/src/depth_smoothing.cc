#include <highwall/mapping/depth_smoothing.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/require.h>

namespace highwall {
namespace {

constexpr float kTableStep = 0.02f;  // [m]
constexpr int kSamples = 2;          // on each side of a pixel

// Half a window [px] and the gate [1/m], tabulated by depth in steps of kTableStep.
struct Window {
  int radius = 0;
  float gate = 0.0f;
};

// Returns the table index of a depth z [m]. It does not decrease with z, so a table up to the
// farthest depth has an entry for every depth.
std::size_t TableIndex(float z) {
  return static_cast<std::size_t>(z / kTableStep);
}

// Returns the window for a depth z [m] with the standard deviation s [m].
Window MakeWindow(double z, double s, double focal, const DepthSmoothingOptions& options) {
  // The mean of n independent depths has the standard deviation sigma / sqrt(n), and a window has
  // (2 r / grain)^2 of them.
  const double wanted =
      s > options.target_sigma ? 0.5 * options.grain * s / options.target_sigma : 0.0;
  const double allowed = std::max(options.max_extent, s) * focal / z;
  const double radius = std::min({wanted, allowed, static_cast<double>(options.max_radius)});
  return {static_cast<int>(radius), static_cast<float>(options.gate * s / (z * z))};
}

std::vector<Window> MakeTable(float farthest, double focal, const DepthSigma& sigma,
                              const DepthSmoothingOptions& options) {
  std::vector<Window> table(TableIndex(farthest) + 1);
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double z = (static_cast<double>(i) + 0.5) * kTableStep;
    table[i] = MakeWindow(z, sigma(z), focal, options);
  }
  return table;
}

// Returns the mean inverse depth of a window. inverse: 0 where not measured. A few evenly spread
// pixels represent the whole window, as the noise of neighbouring pixels is correlated. They are
// used in pairs, one on each side of the centre, whose mean equals the centre on any plane, however
// steep.
float WindowMean(const cv::Mat& inverse, int u, int v, const Window& window) {
  const auto value = [&](int du, int dv) {
    const int column = u + du, row = v + dv;
    const bool inside = column >= 0 && row >= 0 && column < inverse.cols && row < inverse.rows;
    return inside ? inverse.at<float>(row, column) : 0.0f;
  };
  const float centre = inverse.at<float>(v, u);
  float sum = centre;
  float count = 1.0f;
  for (int j = 0; j <= kSamples; ++j) {
    for (int i = j == 0 ? 1 : -kSamples; i <= kSamples; ++i) {
      const int du = i * window.radius / kSamples, dv = j * window.radius / kSamples;
      const float a = value(du, dv), b = value(-du, -dv);
      if (a == 0.0f || b == 0.0f || std::abs(0.5f * (a + b) - centre) > window.gate) continue;
      sum += a + b;
      count += 2.0f;
    }
  }
  return sum / count;
}

}  // namespace

void DepthSmoothingOptions::Validate() const {
  const auto require = [](bool valid, const char* field, double value) {
    HIGHWALL_REQUIRE(valid, "DepthSmoothingOptions::" + std::string(field) +
                                " is out of range: " + FixedText(value));
  };
  require(target_sigma > 0.0, "target_sigma", target_sigma);
  require(max_extent > 0.0, "max_extent", max_extent);
  require(max_radius >= 0, "max_radius", max_radius);
  require(grain > 0.0, "grain", grain);
  require(gate > 0.0, "gate", gate);
}

cv::Mat SmoothDepth(const cv::Mat& depth, double focal, const DepthSigma& sigma,
                    const DepthSmoothingOptions& options, const cv::Mat& noise_factor) {
  options.Validate();
  RequirePositive(focal, "focal");
  if (depth.empty()) return depth;
  HIGHWALL_REQUIRE(depth.type() == CV_32FC1, "a depth image is CV_32FC1, in metres");
  HIGHWALL_REQUIRE(noise_factor.empty() ||
                       (noise_factor.type() == CV_32FC1 && noise_factor.size() == depth.size()),
                   "the factors on its noise are CV_32FC1 of the size of the depth image");
  cv::Mat inverse(depth.size(), CV_32FC1);
  float farthest = 0.0f;
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const float z = depth.at<float>(v, u);
      const bool measured = z > 0.0f && std::isfinite(z);
      inverse.at<float>(v, u) = measured ? 1.0f / z : 0.0f;
      if (measured) farthest = std::max(farthest, z);
    }
  }
  const std::vector<Window> table = MakeTable(farthest, focal, sigma, options);
  cv::Mat smooth = depth.clone();
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      if (inverse.at<float>(v, u) == 0.0f) continue;
      const float z = depth.at<float>(v, u);
      const float factor = noise_factor.empty() ? 1.0f : noise_factor.at<float>(v, u);
      const Window window =
          factor == 1.0f ? table[TableIndex(z)] : MakeWindow(z, factor * sigma(z), focal, options);
      if (window.radius > 0) smooth.at<float>(v, u) = 1.0f / WindowMean(inverse, u, v, window);
    }
  }
  return smooth;
}

}  // namespace highwall
