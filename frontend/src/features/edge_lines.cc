#include "features/edge_lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <cstring>

namespace highwall::internal {
namespace {

// [grey levels per px] smallest gradient of an edge as |d/dx| + |d/dy|. Noise of 5 grey levels
// gives 1.1 with a standard deviation of 0.6 after ImageGradient's blur.
constexpr double kMinEdge = 2.5;
// [grey levels per px] the least by which an anchor is above the mean of those on both sides.
constexpr double kMinAnchor = 0.66;
constexpr auto kMinMagnitude = static_cast<std::int16_t>(kMinEdge * ImageGradient::kUnit);
constexpr auto kMinRise = static_cast<std::int16_t>(kMinAnchor * ImageGradient::kUnit);
// [px] between the columns in which anchors of level edges are sought, and between the rows in
// which those of steep ones are: no segment of interest is shorter.
constexpr int kAnchorStep = 4;
constexpr std::int16_t kDrawn = 1;  // bit of a magnitude

// Number of pixels up to which the least number of aligned ones is computed.
constexpr std::size_t kMaxCount = 128;

// Returns, by the number of pixels of a segment, how many must have a gradient within 22.5 degrees
// of the normal so that an image of independent, equally distributed directions has less than one
// such segment on average (Desolneux, Moisan, Morel, "Meaningful alignments", 2000).
std::vector<std::size_t> MinAligned(int width, int height) {
  constexpr double kChance = 0.125;  // 45 degrees of 360
  // Any two pixels may be the ends of a segment.
  const double log_segments = 2.0 * (std::log(width) + std::log(height));
  std::array<double, kMaxCount + 1> log_factorial{};
  for (std::size_t n = 1; n <= kMaxCount; ++n) {
    log_factorial[n] = log_factorial[n - 1] + std::log(static_cast<double>(n));
  }
  std::vector<std::size_t> min_aligned(kMaxCount + 1);
  for (std::size_t n = 0; n <= kMaxCount; ++n) {
    // Expected number of segments with k or more aligned pixels: the tail of a binomial
    // distribution, from k = n down.
    double expected = 0.0;
    min_aligned[n] = n + 1;
    for (std::size_t misaligned = 0; misaligned <= n; ++misaligned) {
      const std::size_t k = n - misaligned;
      expected += std::exp(log_segments + log_factorial[n] - log_factorial[k] -
                           log_factorial[misaligned] + static_cast<double>(k) * std::log(kChance) +
                           static_cast<double>(misaligned) * std::log(1.0 - kChance));
      if (expected > 1.0) break;
      min_aligned[n] = k;
    }
  }
  return min_aligned;
}

// Writes the magnitudes of a row. They fit: the sum of both derivatives has positive weights of 6
// in all on the blurred image, which is at most 16 x 255.
void WriteMagnitudes(const std::int16_t* gradient, int width, std::int16_t* magnitude) {
  for (int x = 0; x < width; ++x) {
    const auto dx = gradient[2 * x], dy = gradient[2 * x + 1];
    const auto ax = static_cast<std::int16_t>(dx < 0 ? -dx : dx);
    const auto ay = static_cast<std::int16_t>(dy < 0 ? -dy : dy);
    const auto sum = static_cast<std::int16_t>((ax + ay) & ~kDrawn);
    magnitude[x] = sum < kMinMagnitude ? std::int16_t{0} : sum;
  }
  magnitude[0] = magnitude[width - 1] = 0;
}

// Returns whether an edge is steep: whether the gradient is nearer to the x axis.
bool IsSteep(const std::int16_t* gradient) {
  return std::abs(gradient[0]) > std::abs(gradient[1]);
}

// Returns whether a magnitude is a clear maximum between its neighbours. Of two equal ones in the
// middle of an edge, the second is.
bool IsMaximum(std::int16_t before, std::int16_t magnitude, std::int16_t after) {
  const auto rise = static_cast<std::int16_t>(magnitude - before);
  const auto fall = static_cast<std::int16_t>(magnitude - after);
  return rise >= 0 && fall > 0 && static_cast<std::int16_t>((rise + fall) / 2) >= kMinRise;
}

// Writes which pixels of a row are maxima along it: 1 or 0. Few are: this loop without branches,
// and a search, are faster than one loop.
void WriteMaxima(const std::int16_t* row, int width, std::uint8_t* is_maximum) {
  for (int x = 1; x + 1 < width; ++x) {
    is_maximum[x] = IsMaximum(row[x - 1], row[x], row[x + 1]) ? 1 : 0;
  }
}

}  // namespace

// y = a + b x or, if steep, x = a + b y. [px]
struct EdgeLines::Line {
  bool steep = false;
  double a = 0.0, b = 0.0;
  double cosine = 1.0;         // 1 / sqrt(1 + b^2)
  double squared_error = 0.0;  // mean of the squared distances [px^2]

  double Distance(Pixel p) const {
    return std::abs(steep ? p.x - a - b * p.y : p.y - a - b * p.x) * cosine;
  }
  // Returns the foot of the perpendicular.
  Eigen::Vector2f Nearest(Pixel p) const {
    const double along = steep ? p.y : p.x, across = steep ? p.x : p.y;
    const double t = (along + b * (across - a)) * cosine * cosine, s = a + b * t;
    return Eigen::Vector2d(steep ? s : t, steep ? t : s).cast<float>();
  }
};

void EdgeLines::FindMagnitudes(const ImageGradient& gradient) {
  const auto width = static_cast<std::size_t>(width_), height = static_cast<std::size_t>(height_);
  magnitude_.resize(width * height);
  std::fill_n(magnitude_.begin(), width, std::int16_t{0});
  std::fill_n(magnitude_.end() - width_, width, std::int16_t{0});
  for (int y = 1; y + 1 < height_; ++y) {
    WriteMagnitudes(gradient.Row(y), width_, &MagnitudeAt({0, y}));
  }
}

void EdgeLines::FindAnchors(const ImageGradient& gradient) {
  const int width = width_;  // of the loops, whose writes might change a member as far as is known
  anchors_.clear();
  is_maximum_.assign(static_cast<std::size_t>(width), 0);
  std::uint8_t *const begin = is_maximum_.data(), *const end = begin + is_maximum_.size();
  for (int y = 1; y + 1 < height_; ++y) {
    const std::int16_t *g = gradient.Row(y), *row = &MagnitudeAt({0, y});
    const std::int16_t *above = row - width, *below = row + width;
    for (int x = kAnchorStep; x + 1 < width; x += kAnchorStep) {
      if (IsMaximum(above[x], row[x], below[x]) && !IsSteep(g + 2 * x)) anchors_.push_back({x, y});
    }
    if (y % kAnchorStep != 0) continue;
    WriteMaxima(row, width, begin);
    const auto next = [end](std::uint8_t* from) {
      return static_cast<std::uint8_t*>(std::memchr(from, 1, static_cast<std::size_t>(end - from)));
    };
    for (std::uint8_t* p = next(begin); p != nullptr; p = next(p + 1)) {
      const auto x = static_cast<int>(p - begin);
      if (IsSteep(g + 2 * x)) anchors_.push_back({x, y});
    }
  }
}

// The border has no magnitude, so that a chain never reaches it, and neighbours are in the image.
void EdgeLines::Follow(const ImageGradient& gradient, Pixel pixel, int sign) {
  constexpr float kMinCosine = 0.85F;  // of the angle between the gradients of neighbours
  const std::int16_t* g = gradient.Row(pixel.y) + 2 * pixel.x;
  for (;;) {
    // The bright side is to the left of (-dy, dx). The next pixel is the strongest of the three
    // ahead; of equal ones, that straight ahead.
    const int dx = g[0], dy = g[1];
    const bool steep = IsSteep(g);
    const int ahead = (steep ? dx > 0 : dy < 0) ? sign : -sign;
    const std::ptrdiff_t forward = steep ? width_ : 1, aside = steep ? 1 : width_;
    std::int16_t* next = &MagnitudeAt(pixel) + ahead * forward;
    int turn = 0;
    if (next[-aside] > next[0]) turn = -1;
    if (next[aside] > next[turn * aside]) turn = 1;
    next += turn * aside;
    if (*next == 0 || (*next & kDrawn) != 0) return;
    pixel = steep ? Pixel{pixel.x + turn, pixel.y + ahead} : Pixel{pixel.x + ahead, pixel.y + turn};
    g = gradient.Row(pixel.y) + 2 * pixel.x;
    const auto dot = static_cast<float>(dx * g[0] + dy * g[1]);
    const auto square = static_cast<float>(dx * dx + dy * dy);
    const auto next_square = static_cast<float>(g[0] * g[0] + g[1] * g[1]);
    if (dot <= 0.0F || dot * dot < kMinCosine * kMinCosine * square * next_square) return;
    *next |= kDrawn;
    chain_.push_back(pixel);
  }
}

void EdgeLines::Draw(const ImageGradient& gradient, Pixel anchor) {
  chain_.clear();
  MagnitudeAt(anchor) |= kDrawn;
  Follow(gradient, anchor, -1);
  std::reverse(chain_.begin(), chain_.end());
  chain_.push_back(anchor);
  Follow(gradient, anchor, 1);
}

void EdgeLines::SumChain() {
  sums_.resize(chain_.size() + 1);
  Sums sums{};
  for (std::size_t i = 0; i < chain_.size(); ++i) {
    sums_[i] = sums;
    const std::int64_t x = chain_[i].x, y = chain_[i].y;
    sums = {sums.x + x, sums.y + y, sums.xx + x * x, sums.xy + x * y, sums.yy + y * y};
  }
  sums_.back() = sums;
}

// No two pixels of a chain are the same, so that the larger variance is not zero.
EdgeLines::Line EdgeLines::Fit(std::size_t begin, std::size_t end) const {
  const Sums &from = sums_[begin], &to = sums_[end];
  const auto n = static_cast<double>(end - begin);
  const auto x = static_cast<double>(to.x - from.x), y = static_cast<double>(to.y - from.y);
  const double mean_x = x / n, mean_y = y / n;
  const double xx = static_cast<double>(to.xx - from.xx) - x * mean_x;
  const double xy = static_cast<double>(to.xy - from.xy) - x * mean_y;
  const double yy = static_cast<double>(to.yy - from.yy) - y * mean_y;
  Line line;
  line.steep = yy > xx;
  const double along = line.steep ? yy : xx, across = line.steep ? xx : yy;
  line.b = xy / along;
  line.a = line.steep ? mean_x - line.b * mean_y : mean_y - line.b * mean_x;
  const double square = 1.0 / (1.0 + line.b * line.b);
  line.cosine = std::sqrt(square);
  line.squared_error = std::max(across - line.b * xy, 0.0) / n * square;
  return line;
}

std::size_t EdgeLines::Extend(std::size_t begin, std::size_t end, Line* line) const {
  constexpr double kMaxDistance = 1.5;   // [px] of a pixel from the line
  constexpr std::size_t kMaxMissed = 4;  // consecutive pixels that are farther away
  constexpr std::size_t kInterval = 4;   // [pixels] between fits
  std::size_t fitted = end;
  for (std::size_t i = end; i < chain_.size() && i < end + kMaxMissed; ++i) {
    if (line->Distance(chain_[i]) > kMaxDistance) continue;
    end = i + 1;
    if (end < fitted + kInterval) continue;
    *line = Fit(begin, end);
    fitted = end;
  }
  if (fitted != end) *line = Fit(begin, end);
  return end;
}

bool EdgeLines::IsMeaningful(const ImageGradient& gradient, const LineSegment& segment,
                             std::size_t begin, std::size_t end) const {
  constexpr float kTangent = 0.41421356F;  // of 22.5 degrees
  const Eigen::Vector2f d = segment.e - segment.s;
  std::size_t aligned = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const std::int16_t* g = gradient.Row(chain_[i].y) + 2 * chain_[i].x;
    const auto dx = static_cast<float>(g[0]), dy = static_cast<float>(g[1]);
    // Along the segment, and towards its bright side.
    aligned += std::abs(d.x() * dx + d.y() * dy) <= kTangent * (d.y() * dx - d.x() * dy) ? 1U : 0U;
  }
  // The share that suffices falls with the number: that of kMaxCount is safe for more.
  const std::size_t count = end - begin;
  return count <= kMaxCount ? aligned >= min_aligned_[count]
                            : aligned * kMaxCount >= min_aligned_[kMaxCount] * count;
}

void EdgeLines::Divide(const ImageGradient& gradient, float min_length,
                       std::vector<LineSegment>* lines) {
  constexpr double kMaxError = 0.5;  // [px] root of the mean square at the beginning of a line
  // Diagonal pixels are sqrt(2) apart.
  const auto window = std::max<std::size_t>(static_cast<std::size_t>(min_length / 1.4143F), 3);
  if (chain_.size() < window) return;
  SumChain();
  const Eigen::Array2f limit(static_cast<float>(width_ - 1), static_cast<float>(height_ - 1));
  const auto clipped = [&](const Eigen::Vector2f& p) -> Eigen::Vector2f {
    return p.array().max(0.0F).min(limit);
  };
  std::size_t begin = 0;
  while (begin + window <= chain_.size()) {
    Line line = Fit(begin, begin + window);
    if (line.squared_error > kMaxError * kMaxError) {
      ++begin;
      continue;
    }
    const std::size_t end = Extend(begin, begin + window, &line);
    const LineSegment whole{line.Nearest(chain_[begin]), line.Nearest(chain_[end - 1])};
    const LineSegment segment{clipped(whole.s), clipped(whole.e)};
    if (segment.Length() >= min_length && IsMeaningful(gradient, whole, begin, end)) {
      lines->push_back(segment);
    }
    begin = end;
  }
}

std::vector<LineSegment> EdgeLines::Detect(const ImageGradient& gradient, float min_length) {
  if (gradient.width() != width_ || gradient.height() != height_) {
    width_ = gradient.width();
    height_ = gradient.height();
    min_aligned_ = MinAligned(width_, height_);
  }
  FindMagnitudes(gradient);
  FindAnchors(gradient);
  std::vector<LineSegment> lines;
  for (const Pixel& anchor : anchors_) {
    if ((MagnitudeAt(anchor) & kDrawn) != 0) continue;
    Draw(gradient, anchor);
    Divide(gradient, min_length, &lines);
  }
  return lines;
}

}  // namespace highwall::internal
