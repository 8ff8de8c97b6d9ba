#include "features/fast_corners.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <utility>

#include <highwall/internal/target_clones.h>

#include "features/fast_score.h"

namespace highwall::internal {
namespace {

using Word = std::uint64_t;  // of pixels, most of which are no corners
constexpr int kScoredRows = 3;
constexpr int kRadius = 3;  // [px] of the circle
constexpr int kLanes = 32;  // pixels of a row that are scored together
constexpr std::size_t kCircle = FastCircle::kPixels.size();

// A pixel in each lane. Functions of Lanes are inlined into the clones of ScoreRow().
using Lanes [[gnu::vector_size(kLanes)]] = std::uint8_t;

[[gnu::always_inline]] inline void LowerTo(const Lanes& other, Lanes* lanes) {
  *lanes = *lanes < other ? *lanes : other;
}
[[gnu::always_inline]] inline void RaiseTo(const Lanes& other, Lanes* lanes) {
  *lanes = *lanes > other ? *lanes : other;
}

using Circle = std::array<Lanes, kCircle>;
using Places = std::make_index_sequence<kCircle>;

// Combines each value on the circle with the one `step` places further on. The loop is unrolled, so
// that the circle is kept in registers.
template <std::size_t step, void (*kTo)(const Lanes&, Lanes*), std::size_t... i>
[[gnu::always_inline]] inline void Combine(Circle* circle, std::index_sequence<i...>) {
  const Circle before = *circle;
  (kTo(before[(i + step) % kCircle], &(*circle)[i]), ...);
}

// Replaces values on the circle by the extrema over the arcs of 9 that begin with them; those over
// arcs of 2, 4, 8 and 9 pixels are computed from the previous ones.
template <void (*kTo)(const Lanes&, Lanes*)>
[[gnu::always_inline]] inline void TakeOverArcs(Circle* circle) {
  Combine<1, kTo>(circle, Places());
  Combine<2, kTo>(circle, Places());
  Combine<4, kTo>(circle, Places());
  Combine<1, kTo>(circle, Places());
}

// Returns the extremum of all values.
template <void (*kTo)(const Lanes&, Lanes*), std::size_t... i>
[[gnu::always_inline]] inline void TakeAll(const Circle& circle, Lanes* best,
                                           std::index_sequence<i...>) {
  (kTo(circle[i], best), ...);
}

template <std::size_t... i>
[[gnu::always_inline]] inline void LoadCircle(const std::uint8_t* centre,
                                              const std::ptrdiff_t* offsets, Circle* circle,
                                              std::index_sequence<i...>) {
  (std::memcpy(&(*circle)[i], centre + offsets[i], sizeof(Lanes)), ...);
}

[[gnu::always_inline]] inline bool IsAnySet(const Lanes& lanes) {
  std::array<std::uint64_t, kLanes / sizeof(std::uint64_t)> words;
  std::memcpy(words.data(), &lanes, sizeof(lanes));
  return (words[0] | words[1] | words[2] | words[3]) != 0;
}

// Computes the scores of the pixels of which `centre` is the first: OpenCV's, the highest threshold
// with which a pixel is still a corner, or 0.
[[gnu::always_inline]] inline void ScoreLanes(const std::uint8_t* centre,
                                              const std::ptrdiff_t* offsets, std::uint8_t threshold,
                                              std::uint8_t* scores) {
  // Most groups of pixels have no candidate: any arc of 9 contains one of each two opposite pixels.
  Lanes value, above = ~Lanes{}, below{};
  std::memcpy(&value, centre, sizeof(value));
  for (std::size_t i = 0; i < kCircle / 2; i += 2) {
    Lanes a, b;
    std::memcpy(&a, centre + offsets[i], sizeof(a));
    std::memcpy(&b, centre + offsets[i + kCircle / 2], sizeof(b));
    Lanes low = a;
    LowerTo(b, &low);
    RaiseTo(a, &b);
    LowerTo(b, &above);
    RaiseTo(low, &below);
  }
  RaiseTo(value, &above);
  LowerTo(value, &below);
  const Lanes least = Lanes{} + threshold;
  // The comparisons give signed bytes.
  const bool is_any_brighter = IsAnySet(reinterpret_cast<Lanes>(above - value > least));
  const bool is_any_darker = IsAnySet(reinterpret_cast<Lanes>(value - below > least));
  if (!is_any_brighter && !is_any_darker) return;

  Circle circle;
  Lanes contrast{};
  if (is_any_brighter) {
    LoadCircle(centre, offsets, &circle, Places());
    TakeOverArcs<LowerTo>(&circle);
    Lanes best = value;
    TakeAll<RaiseTo>(circle, &best, Places());
    contrast = best - value;
  }
  if (is_any_darker) {
    LoadCircle(centre, offsets, &circle, Places());
    TakeOverArcs<RaiseTo>(&circle);
    Lanes best = value;
    TakeAll<LowerTo>(circle, &best, Places());
    RaiseTo(value - best, &contrast);
  }
  const Lanes score = contrast > least ? contrast - 1 : Lanes{};
  std::memcpy(scores, &score, sizeof(score));
}

// Computes the scores of a row of at least kLanes pixels; the last group of them overlaps the one
// before.
HIGHWALL_TARGET_CLONES("avx2", "default")
void ScoreRow(const std::uint8_t* row, const std::ptrdiff_t* offsets, int count,
              std::uint8_t threshold, std::uint8_t* scores) {
  for (int x = 0; x < count; x += kLanes) {
    const int first = std::min(x, count - kLanes);
    ScoreLanes(row + first, offsets, threshold, scores + first);
  }
}

// Copies the scores of a row that are larger than those of all eight neighbours; the others are 0.
HIGHWALL_TARGET_CLONES("avx2", "default")
void KeepPeaks(const std::uint8_t* a, const std::uint8_t* b, const std::uint8_t* c,
               std::size_t count, std::uint8_t* __restrict peaks) {
  for (std::size_t x = 1; x <= count; ++x) {
    const std::uint8_t beside = std::max(b[x - 1], b[x + 1]);
    const std::uint8_t above = std::max(std::max(a[x - 1], a[x]), a[x + 1]);
    const std::uint8_t below = std::max(std::max(c[x - 1], c[x]), c[x + 1]);
    peaks[x - 1] = b[x] > std::max(std::max(beside, above), below) ? b[x] : std::uint8_t{0};
  }
}

// Computes the scores of a row of fewer pixels.
void ScoreShortRow(const std::uint8_t* first, std::ptrdiff_t stride, int count,
                   std::uint8_t threshold, std::uint8_t* scores) {
  constexpr int kSide = 2 * kRadius + 1, kStride = kLanes + 2 * kRadius;
  static const FastCircle kCircleOfCopy(kStride);
  std::array<std::uint8_t, kSide * kStride> copy{};
  for (int y = 0; y < kSide; ++y) {
    std::memcpy(&copy[static_cast<std::size_t>(y * kStride)],
                first + (y - kRadius) * stride - kRadius,
                static_cast<std::size_t>(count + 2 * kRadius));
  }
  std::array<std::uint8_t, kLanes> all{};
  ScoreRow(&copy[kRadius * kStride + kRadius], kCircleOfCopy.offsets.data(), kLanes, threshold,
           all.data());
  std::copy_n(all.begin(), count, scores);
}

}  // namespace

void FastCorners::Append(const cv::Mat& image, const cv::Rect& area, int threshold,
                         std::vector<cv::KeyPoint>* corners) {
  const auto image_stride = static_cast<std::ptrdiff_t>(image.step[0]);
  const FastCircle circle(image_stride);
  const auto least = static_cast<std::uint8_t>(threshold);
  const auto stride = static_cast<std::size_t>(area.width) + 2;
  scores_.assign(kScoredRows * stride, 0);
  peaks_.assign(static_cast<std::size_t>(area.width) + sizeof(Word), 0);
  const auto scores_of = [&](int y) {
    return scores_.data() + static_cast<std::size_t>((y + kScoredRows) % kScoredRows) * stride;
  };
  for (int y = 0; y <= area.height; ++y) {
    std::uint8_t* scores = scores_of(y);
    std::fill_n(scores, stride, std::uint8_t{0});
    if (y < area.height) {
      const auto* row = image.ptr<std::uint8_t>(area.y + y) + area.x;
      if (area.width < kLanes) {
        ScoreShortRow(row, image_stride, area.width, least, scores + 1);
      } else {
        ScoreRow(row, circle.offsets.data(), area.width, least, scores + 1);
      }
    }
    if (y == 0) continue;
    KeepPeaks(scores_of(y - 2), scores_of(y - 1), scores, static_cast<std::size_t>(area.width),
              peaks_.data());
    AppendPeaks({area.x, area.y + y - 1}, corners);
  }
}

void FastCorners::AppendPeaks(const cv::Point& first, std::vector<cv::KeyPoint>* corners) const {
  for (std::size_t word = 0; word + sizeof(Word) <= peaks_.size(); word += sizeof(Word)) {
    Word any = 0;
    std::memcpy(&any, &peaks_[word], sizeof(any));
    if (any == 0) continue;
    for (std::size_t x = word; x < word + sizeof(Word); ++x) {
      if (peaks_[x] == 0) continue;
      corners->emplace_back(static_cast<float>(first.x + static_cast<int>(x)),
                            static_cast<float>(first.y), 7.0F, -1.0F,
                            static_cast<float>(peaks_[x]));
    }
  }
}

}  // namespace highwall::internal
