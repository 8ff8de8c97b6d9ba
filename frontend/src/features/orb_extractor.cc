#include <highwall/frontend/features/orb_extractor.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>

#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>

#include "features/corner_refinement.h"
#include "features/fast_corners.h"
#include "features/image_noise.h"
#include "features/orb_descriptor.h"
#include "features/square_suppression.h"

namespace highwall {
namespace {

constexpr int kPatchRadius = 15;  // [px] of the intensity centroid, Rublee et al. 2011
constexpr int kPatchSize = 31;    // [px] of the descriptor
constexpr int kBorder = 17;       // [px] corners closer to the edge of a level are not used
constexpr int kCellSize = 32;     // [px of the level] searched again if FAST finds nothing
constexpr int kCornerArea = 64;   // [px] per corner, of an image of rich texture
constexpr int kMinLevelSide = 2 * kBorder + 8;  // [px] smallest level that is searched

// Returns half the chord of the circular patch in each row.
std::array<int, kPatchRadius + 1> PatchHalfWidths() {
  std::array<int, kPatchRadius + 1> half_widths{};
  for (int v = 0; v <= kPatchRadius; ++v) {
    half_widths[static_cast<std::size_t>(v)] =
        static_cast<int>(std::floor(std::sqrt(kPatchRadius * kPatchRadius - v * v) + 0.5));
  }
  return half_widths;
}

// Returns the direction [deg] from the corner to the intensity centroid around it.
float IntensityCentroidAngle(const cv::Mat& image, int x, int y) {
  static const std::array<int, kPatchRadius + 1> half_widths = PatchHalfWidths();
  int m10 = 0, m01 = 0;
  for (int v = -kPatchRadius; v <= kPatchRadius; ++v) {
    const int half_width = half_widths[static_cast<std::size_t>(std::abs(v))];
    const uchar* row = image.ptr<uchar>(y + v) + x;
    int sum = 0, moment = 0;
    for (int u = -half_width; u <= half_width; ++u) {
      sum += row[u];
      moment += u * row[u];
    }
    m10 += moment;
    m01 += v * sum;
  }
  return cv::fastAtan2(static_cast<float>(m01), static_cast<float>(m10));
}

// Returns the area of the pixels that may be corners.
cv::Rect SearchArea(const cv::Mat& image) {
  return {kBorder, kBorder, image.cols - 2 * kBorder, image.rows - 2 * kBorder};
}

bool IsSearched(const cv::Mat& image) {
  return std::min(image.cols, image.rows) >= kMinLevelSide;
}

// Runs FAST in the cells of a level that have no corner yet; adjacent empty cells in a row are
// searched together.
void FillEmptyCells(const cv::Mat& image, int size, int threshold,
                    std::vector<cv::KeyPoint>* corners) {
  internal::FastCorners search;
  const cv::Rect area = SearchArea(image);
  const int columns = (area.width + size - 1) / size, rows = (area.height + size - 1) / size;
  std::vector<bool> occupied(static_cast<std::size_t>(columns * rows), false);
  for (const cv::KeyPoint& corner : *corners) {
    const int column = (static_cast<int>(corner.pt.x) - area.x) / size;
    const int row = (static_cast<int>(corner.pt.y) - area.y) / size;
    occupied[static_cast<std::size_t>(row * columns + column)] = true;
  }
  const auto is_empty = [&](int row, int column) {
    return !occupied[static_cast<std::size_t>(row * columns + column)];
  };
  for (int row = 0; row < rows; ++row) {
    for (int first = 0; first < columns; ++first) {
      int end = first;
      while (end < columns && is_empty(row, end)) ++end;
      if (end == first) continue;
      const cv::Rect cells(area.x + first * size, area.y + row * size, (end - first) * size, size);
      search.Append(image, cells & area, threshold, corners);
      first = end;
    }
  }
}

// Runs FAST over the whole level, then with the lower threshold in cells where that finds nothing.
std::vector<cv::KeyPoint> DetectCorners(const cv::Mat& image, const OrbExtractorOptions& options) {
  if (!IsSearched(image)) return {};
  std::vector<cv::KeyPoint> corners;
  corners.reserve(static_cast<std::size_t>(SearchArea(image).area() / kCornerArea));
  internal::FastCorners().Append(image, SearchArea(image), options.fast_threshold, &corners);
  if (options.min_fast_threshold < options.fast_threshold) {
    FillEmptyCells(image, kCellSize, options.min_fast_threshold, &corners);
  }
  return corners;
}

// Lowers the threshold to the image noise in cells that are still empty. noise: sigma on this level
// [grey levels].
void AppendLowContrastCorners(const cv::Mat& image, double noise,
                              const OrbExtractorOptions& options,
                              std::vector<cv::KeyPoint>* corners) {
  constexpr double kSigmas = 2.0;
  constexpr int kLeast = 2;  // [grey levels] above the quantization of the image
  if (!IsSearched(image)) return;
  const int threshold = std::max(kLeast, static_cast<int>(std::ceil(kSigmas * noise)));
  if (threshold >= options.min_fast_threshold) return;
  FillEmptyCells(image, kCellSize, threshold, corners);
}

int NumCorners(const std::vector<std::vector<cv::KeyPoint>>& levels) {
  return std::transform_reduce(levels.begin(), levels.end(), 0, std::plus<>(),
                               [](const auto& level) { return static_cast<int>(level.size()); });
}

}  // namespace

struct OrbExtractor::Impl {
  OrbExtractorOptions options;
  FeatureType kind;
  std::vector<double> scales;
  std::vector<double> noise_shares;  // share of the sigma of white noise that remains on each level

  explicit Impl(const OrbExtractorOptions& o) : options(o) {
    options.Validate();
    kind.pyramid = options.pyramid;
    kind.low_contrast_response = static_cast<float>(options.min_fast_threshold);
    for (int i = 0; i < options.pyramid.levels; ++i)
      scales.push_back(std::pow(options.pyramid.scale_factor, i));
    noise_shares = NoiseShares();
  }

  std::vector<double> NoiseShares() const {
    constexpr int kSide = 320;       // [px] sufficient to estimate the sigma of eight usual levels
    constexpr double kNoise = 20.0;  // [grey levels] large compared with rounding
    cv::Mat noise(kSide, kSide, CV_8UC1);
    cv::RNG(1).fill(noise, cv::RNG::NORMAL, 128.0, kNoise);
    std::vector<double> shares;
    for (const cv::Mat& level : BuildPyramid(noise)) {
      cv::Scalar mean, sigma;
      cv::meanStdDev(level, mean, sigma);
      shares.push_back(sigma[0] / kNoise);
    }
    while (shares.size() < scales.size()) {
      shares.push_back(shares.back() / options.pyramid.scale_factor);
    }
    return shares;
  }

  std::vector<cv::Mat> BuildPyramid(const cv::Mat& gray) const {
    std::vector<cv::Mat> pyramid = {gray};
    for (int i = 1; i < options.pyramid.levels; ++i) {
      const double scale = scales[static_cast<std::size_t>(i)];
      const cv::Size size(cvRound(gray.cols / scale), cvRound(gray.rows / scale));
      if (std::min(size.width, size.height) < kMinLevelSide) break;
      cv::Mat image;
      cv::resize(pyramid.back(), image, size, 0, 0, cv::INTER_LINEAR_EXACT);
      pyramid.push_back(std::move(image));
    }
    return pyramid;
  }

  // Returns how many corners each level keeps: in proportion to the inverse scale; unused shares of
  // a level go to the others, the finest first.
  std::vector<int> Budgets(const std::vector<std::vector<cv::KeyPoint>>& corners) const {
    double total = 0.0;
    for (const double scale : scales) total += 1.0 / scale;
    std::vector<int> budgets(corners.size());
    int left = options.features;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const int share = cvRound(options.features / (scales[i] * total));
      budgets[i] = std::min({share, left, static_cast<int>(corners[i].size())});
      left -= budgets[i];
    }
    for (std::size_t i = 0; i < corners.size() && left > 0; ++i) {
      const int more = std::min(left, static_cast<int>(corners[i].size()) - budgets[i]);
      budgets[i] += more;
      left -= more;
    }
    return budgets;
  }

  // Computes angle, descriptor and image coordinates of the corners of one level.
  ExtractedPoints Describe(const cv::Mat& image, const cv::Size& full_size, std::size_t level,
                           std::vector<cv::KeyPoint> corners) const {
    ExtractedPoints features;
    if (corners.empty()) return features;
    for (cv::KeyPoint& corner : corners) {
      corner.angle = IntensityCentroidAngle(image, cvRound(corner.pt.x), cvRound(corner.pt.y));
    }
    features.descriptors = internal::DescribeOrb(image, corners);
    // cv::resize aligns the outer edges of the images, not the centres of their first pixels.
    const float sx = static_cast<float>(full_size.width) / static_cast<float>(image.cols);
    const float sy = static_cast<float>(full_size.height) / static_cast<float>(image.rows);
    for (cv::KeyPoint& corner : corners) {
      if (options.subpixel) {
        corner.pt += internal::RefineCorner(image, cvRound(corner.pt.x), cvRound(corner.pt.y));
      }
      corner.pt.x = (corner.pt.x + 0.5F) * sx - 0.5F;
      corner.pt.y = (corner.pt.y + 0.5F) * sy - 0.5F;
      corner.octave = static_cast<int>(level);
      corner.size = kPatchSize * static_cast<float>(scales[level]);
    }
    features.keypoints = std::move(corners);
    return features;
  }
};

OrbExtractor::OrbExtractor(const OrbExtractorOptions& options)
    : impl_(std::make_unique<const Impl>(options)) {}
OrbExtractor::~OrbExtractor() = default;
OrbExtractor::OrbExtractor(OrbExtractor&&) noexcept = default;
OrbExtractor& OrbExtractor::operator=(OrbExtractor&&) noexcept = default;

const FeatureType& OrbExtractor::kind() const {
  return impl_->kind;
}

double OrbExtractor::Scale(int level) const {
  HIGHWALL_REQUIRE(level >= 0 && level < impl_->options.pyramid.levels,
                   "OrbExtractor::Scale: no such level");
  return impl_->scales[static_cast<std::size_t>(level)];
}

ExtractedPoints OrbExtractor::Extract(const cv::Mat& gray) {
  HIGHWALL_REQUIRE(!gray.empty() && gray.type() == CV_8UC1,
                   "OrbExtractor::Extract: the image must be CV_8UC1 and not empty");
  const std::vector<cv::Mat> pyramid = impl_->BuildPyramid(gray);
  std::vector<std::vector<cv::KeyPoint>> corners(pyramid.size());
  const auto each_level = [&](const auto& work) {
    cv::parallel_for_(cv::Range(0, static_cast<int>(pyramid.size())), [&](const cv::Range& range) {
      for (int i = range.start; i < range.end; ++i) work(static_cast<std::size_t>(i));
    });
  };
  each_level([&](std::size_t i) { corners[i] = DetectCorners(pyramid[i], impl_->options); });
  if (NumCorners(corners) < impl_->options.features) {
    const double noise = internal::NoiseSigma(gray);
    each_level([&](std::size_t i) {
      AppendLowContrastCorners(pyramid[i], noise * impl_->noise_shares[i], impl_->options,
                               &corners[i]);
    });
  }
  const std::vector<int> budgets = impl_->Budgets(corners);
  std::vector<ExtractedPoints> features(pyramid.size());
  each_level([&](std::size_t i) {
    corners[i] = internal::SelectEvenly(corners[i], budgets[i], SearchArea(pyramid[i]));
    features[i] = impl_->Describe(pyramid[i], gray.size(), i, std::move(corners[i]));
  });

  ExtractedPoints joined;
  for (const ExtractedPoints& level : features) {
    if (level.keypoints.empty()) continue;
    joined.keypoints.insert(joined.keypoints.end(), level.keypoints.begin(), level.keypoints.end());
    joined.descriptors.push_back(level.descriptors);
  }
  return joined;
}

}  // namespace highwall
