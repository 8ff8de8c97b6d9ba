#include <highwall/frontend/input/stamp_check.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <optional>

#include <highwall/internal/median.h>
#include <highwall/internal/number_text.h>

namespace highwall {
namespace {

constexpr Stamp kSecond = 1'000'000'000;                                   // [ns]
constexpr double kShortestInterval = 1.0 / 240.0, kLongestInterval = 1.0;  // [s] of a camera
constexpr std::size_t kFewestFrames = 10;

std::string StampText(double seconds) {
  return RoundedText(seconds, 4);
}

std::string FrameCount(std::size_t frames) {
  return std::to_string(frames) + (frames == 1 ? " frame" : " frames");
}

// The order of the stamps: what a run cannot begin with.
void CheckOrder(std::span<const Stamp> stamps, std::vector<StampFinding>* findings) {
  std::size_t equal = 0, back = 0, first_equal = 0, first_back = 0;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    if (stamps[i] == stamps[i - 1] && equal++ == 0) first_equal = i;
    if (stamps[i] < stamps[i - 1] && back++ == 0) first_back = i;
  }
  if (back > 0) {
    findings->push_back({StampFindingKind::kDecreasing,
                         "the stamps of " + FrameCount(back) +
                             " are smaller than those before, the first of frame " +
                             std::to_string(first_back),
                         "list the images in the order in which they were taken"});
  }
  if (equal > 0) {
    findings->push_back({StampFindingKind::kEqual,
                         FrameCount(equal) +
                             " have the stamp of the one before, the first is frame " +
                             std::to_string(first_equal),
                         "give each image a stamp of its own, with enough decimals"});
  }
}

// Intervals between consecutive stamps that ascend [s].
std::vector<double> IntervalsOf(std::span<const Stamp> stamps) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    if (stamps[i] > stamps[i - 1]) intervals.push_back(ToSeconds(stamps[i] - stamps[i - 1]));
  }
  return intervals;
}

// Whole seconds, most of them one apart, from a stamp that is a count of frames and no date.
bool AreFrameNumbers(std::span<const Stamp> stamps, const std::vector<double>& intervals) {
  constexpr Stamp kHighest = 1'000'000 * kSecond;  // nine hours at 30 Hz; 11 days after 1970
  const bool whole = std::ranges::all_of(stamps, [](Stamp s) { return s % kSecond == 0; });
  if (!whole || stamps.front() < 0 || stamps.front() > kHighest) return false;
  return 10 * std::ranges::count(intervals, 1.0) >= 9 * std::ssize(intervals);
}

// A unit of stamps by its number in a second.
struct StampUnit {
  const char* name;
  double per_second;
};

// Returns the unit in which an interval, counted in it, is that of a camera.
std::optional<StampUnit> CameraUnitOf(double interval) {
  constexpr std::array<StampUnit, 3> kUnits{
      StampUnit{"milliseconds", 1e3}, {"microseconds", 1e6}, {"nanoseconds", 1e9}};
  for (const StampUnit& unit : kUnits) {
    const double seconds = interval / unit.per_second;
    if (seconds >= kShortestInterval && seconds <= kLongestInterval) return unit;
  }
  return std::nullopt;
}

// Whether the stamps are seconds since 1970 of a day after 1990, so that the unit is known.
bool IsDate(Stamp stamp) {
  return stamp > 631'152'000 * kSecond && stamp < 4'102'444'800 * kSecond;  // until 2100
}

void CheckUnit(std::span<const Stamp> stamps, double interval,
               std::vector<StampFinding>* findings) {
  constexpr double kFastest = 0.5e-3;  // [s] interval of a fast camera, which is no error
  if (interval < kFastest) {
    findings->push_back({StampFindingKind::kUnit,
                         "stamps are too near together for seconds: " + StampText(interval) +
                             " apart in the median",
                         "multiply them by 1000, or write them with enough decimals"});
    return;
  }
  const auto unit = CameraUnitOf(interval);
  if (interval <= kLongestInterval || !unit) return;
  const bool lapse = IsDate(stamps.front());
  findings->push_back(
      {StampFindingKind::kUnit,
       lapse ? "images are " + StampText(interval) + " s apart in the median"
             : "stamps are likely " + std::string(unit->name) + ": they are " +
                   StampText(interval) + " apart",
       lapse ? "no camera that is tracked is so slow; check the unit of the stamps"
             : "divide them by " + RoundedText(unit->per_second, 10) + " to have seconds"});
}

// Images that are stamped when they arrive have intervals shorter than any camera's between long
// ones. The quantile is that of the long intervals where one in six is.
void CheckBursts(std::vector<double> intervals, std::vector<StampFinding>* findings) {
  constexpr double kQuantile = 0.9, kTimes = 10.0;
  constexpr std::ptrdiff_t kTenth = 10;
  std::ranges::sort(intervals);
  const auto place = static_cast<std::size_t>(kQuantile * static_cast<double>(intervals.size()));
  const double usual = intervals[std::min(place, intervals.size() - 1)];
  const auto is_short = [&](double interval) {
    return interval < kShortestInterval && kTimes * interval < usual;
  };
  const auto count = std::ranges::count_if(intervals, is_short);
  if (kTenth * count < std::ssize(intervals)) return;
  findings->push_back({StampFindingKind::kBursts,
                       std::to_string(count) + " of " + std::to_string(intervals.size()) +
                           " intervals between images are shorter than " +
                           StampText(1e3 * kShortestInterval) + " ms, the others " +
                           StampText(1e3 * usual) + " ms",
                       "stamp images when they are taken, not when they arrive"});
}

// interval [s]: of the frames.
void CheckPairs(std::span<const Stamp> depth_delays, double interval,
                std::vector<StampFinding>* findings) {
  constexpr double kLeast = 0.025;  // [s], beyond the limit by default and the usual delays
  if (depth_delays.empty()) return;
  const double delay =
      ToSeconds(UpperMedian(std::vector<Stamp>(depth_delays.begin(), depth_delays.end())));
  if (std::abs(delay) < std::max(kLeast, 0.6 * interval)) return;
  findings->push_back({StampFindingKind::kPairsApart,
                       "depth is " + StampText(1e3 * std::abs(delay)) + " ms " +
                           (delay > 0.0 ? "later" : "earlier") +
                           " than the colour image it is paired with, in the median",
                       "pair images of one time"});
}

}  // namespace

std::vector<StampFinding> CheckStamps(std::span<const Stamp> stamps,
                                      std::span<const Stamp> depth_delays) {
  std::vector<StampFinding> findings;
  if (stamps.size() < kFewestFrames) return findings;
  CheckOrder(stamps, &findings);
  const std::vector<double> intervals = IntervalsOf(stamps);
  if (intervals.size() + 1 < kFewestFrames) return findings;
  const double interval = UpperMedian(intervals);
  if (AreFrameNumbers(stamps, intervals)) {
    findings.push_back({StampFindingKind::kFrameNumbers,
                        "stamps are likely frame numbers: they are whole and one apart",
                        "divide them by the frame rate to have seconds; if images were taken once "
                        "a second, they are right"});
    return findings;
  }
  CheckUnit(stamps, interval, &findings);
  if (findings.empty()) CheckBursts(intervals, &findings);
  CheckPairs(depth_delays, interval, &findings);
  return findings;
}

std::vector<StampFinding> CheckStamps(const Dataset& dataset) {
  std::vector<Stamp> stamps, delays;
  for (std::size_t i = 0; i < dataset.size(); ++i) {
    stamps.push_back(dataset.stamp(i));
    delays.push_back(dataset.depth_stamp(i) - dataset.stamp(i));
  }
  return CheckStamps(stamps, delays);
}

}  // namespace highwall
