#include "input/imu_repetition.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include <highwall/core/stamp.h>

namespace highwall {
namespace {

// Returns the end of the run of equal readings that begins at `begin`.
std::size_t EndOfRun(std::span<const ImuSample> samples, Eigen::Vector3d ImuSample::*sensor,
                     std::size_t begin) {
  std::size_t end = begin + 1;
  while (end < samples.size() && samples[end].*sensor == samples[begin].*sensor) ++end;
  return end;
}

}  // namespace

int RepetitionsOf(std::span<const ImuSample> samples, Eigen::Vector3d ImuSample::*sensor) {
  // A coarse sensor at rest repeats readings as well, but not equally often.
  constexpr double kShare = 0.8;
  constexpr std::size_t kMost = 20, kFewest = 100;
  if (samples.size() < kFewest) return 1;
  std::array<std::size_t, kMost + 1> readings{};  // in runs of each length
  for (std::size_t begin = 0, end = 0; begin < samples.size(); begin = end) {
    end = EndOfRun(samples, sensor, begin);
    if (end - begin <= kMost) readings[end - begin] += end - begin;
  }
  const auto most = std::ranges::max_element(readings);
  if (static_cast<double>(*most) < kShare * static_cast<double>(samples.size())) return 1;
  return static_cast<int>(most - readings.begin());
}

void InterpolateRepeated(std::vector<ImuSample>& samples, Eigen::Vector3d ImuSample::*sensor) {
  for (std::size_t begin = 0, end = 0; begin < samples.size(); begin = end) {
    end = EndOfRun(samples, sensor, begin);
    if (end == samples.size()) break;
    const double duration = ToSeconds(samples[end].stamp - samples[begin].stamp);
    const Eigen::Vector3d from = samples[begin].*sensor, step = samples[end].*sensor - from;
    for (std::size_t i = begin + 1; i < end; ++i) {
      samples[i].*sensor =
          from + ToSeconds(samples[i].stamp - samples[begin].stamp) / duration * step;
    }
  }
}

}  // namespace highwall
