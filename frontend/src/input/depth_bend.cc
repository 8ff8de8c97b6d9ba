#include "input/depth_bend.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace highwall {
namespace {

constexpr int kStepBetweenRuns = 8;  // [px] from one row or column that is examined to the next
constexpr int kStepInRun = 2;        // [px] between the readings of a run
constexpr double kJump = 0.03;       // relative step from a reading to the next: a surface ends
constexpr std::size_t kReadingsOfRun = 24;  // in a run
constexpr double kMinChange = 0.15;  // relative change of 1 / value over a run: less bends little
constexpr double kNear = 0.3;        // of a bend to that of a plane
constexpr double kMinWeight = 2.0;   // of the runs of an image: some ten slanted surfaces

struct Bend {
  double value = 0.0, weight = 0.0;
};

// Fits the polynomial of second order to the inverses of evenly spaced values, with t in [-1, 1].
// Empty if they change too little.
std::optional<Bend> BendOf(const std::vector<double>& inverses) {
  const double middle = 0.5 * static_cast<double>(inverses.size() - 1);
  double s0 = 0.0, s2 = 0.0, s4 = 0.0, y0 = 0.0, y1 = 0.0, y2 = 0.0;
  for (std::size_t i = 0; i < inverses.size(); ++i) {
    const double t = static_cast<double>(i) / middle - 1.0, tt = t * t;
    s0 += 1.0;
    s2 += tt;
    s4 += tt * tt;
    y0 += inverses[i];
    y1 += t * inverses[i];
    y2 += tt * inverses[i];
  }
  const double determinant = s0 * s4 - s2 * s2;
  const double c0 = (s4 * y0 - s2 * y2) / determinant;
  const double c1 = y1 / s2;
  const double c2 = (s0 * y2 - s2 * y0) / determinant;
  const double slope = c1 / c0;
  if (2.0 * std::abs(slope) < kMinChange) return std::nullopt;
  return Bend{c2 / c0 / (slope * slope), slope * slope * static_cast<double>(inverses.size())};
}

// Appends the bends of the surfaces along one row or column. count, stride: of its readings.
void AddRuns(const std::uint16_t* first, int count, std::ptrdiff_t stride,
             std::vector<double>* inverses, std::vector<Bend>* bends) {
  const auto end = [&] {
    if (inverses->size() >= kReadingsOfRun) {
      if (const auto bend = BendOf(*inverses)) bends->push_back(*bend);
    }
    inverses->clear();
  };
  double last = 0.0;
  for (int i = 0; i < count; i += kStepInRun) {
    const double value = first[i * stride];
    if (value == 0.0 || (!inverses->empty() && std::abs(value - last) > kJump * last)) end();
    if (value > 0.0) inverses->push_back(1.0 / value);
    last = value;
  }
  end();
}

// Returns the value up to which the bends have this weight.
double Quantile(std::vector<Bend>* bends, double weight) {
  std::ranges::sort(*bends, {}, &Bend::value);
  double below = 0.0;
  for (const Bend& bend : *bends) {
    below += bend.weight;
    if (below >= weight) return bend.value;
  }
  return bends->back().value;
}

}  // namespace

void DepthBend::Add(const cv::Mat& raw) {
  std::vector<Bend> bends;
  std::vector<double> inverses;
  const auto stride = static_cast<std::ptrdiff_t>(raw.step1());
  for (int v = kStepBetweenRuns / 2; v < raw.rows; v += kStepBetweenRuns) {
    AddRuns(raw.ptr<std::uint16_t>(v), raw.cols, 1, &inverses, &bends);
  }
  for (int u = kStepBetweenRuns / 2; u < raw.cols; u += kStepBetweenRuns) {
    AddRuns(raw.ptr<std::uint16_t>(0) + u, raw.rows, stride, &inverses, &bends);
  }
  double sum = 0.0;
  for (const Bend& bend : bends) sum += bend.weight;
  if (sum < kMinWeight) return;
  const double low = Quantile(&bends, sum / 3.0), high = Quantile(&bends, 2.0 * sum / 3.0);
  const auto both_near = [&](double bend) {
    return std::abs(low - bend) < kNear && std::abs(high - bend) < kNear;
  };
  depth_ += both_near(0.0) ? 1 : 0;
  inverse_ += both_near(1.0) ? 1 : 0;
}

}  // namespace highwall
