#include "input/numbered_frames.h"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include <highwall/core/stamp.h>

#include "input/numbered_files.h"

namespace highwall {
namespace {

// A unit in which UNIX times since 2001 have the least number or a larger one.
struct NumberUnit {
  const char* name;
  std::int64_t least, nanoseconds;
};
constexpr std::array<NumberUnit, 3> kNumberUnits{{{"nanoseconds", 1'000'000'000'000'000'000, 1},
                                                  {"microseconds", 1'000'000'000'000'000, 1000},
                                                  {"milliseconds", 1'000'000'000'000, 1'000'000}}};

// Returns the stamps of ascending numbers, and adds a warning about them.
std::vector<Stamp> StampsOf(const std::filesystem::path& folder,
                            const std::vector<std::int64_t>& numbers, double rate,
                            std::vector<std::string>* warnings) {
  if (numbers.empty()) return {};
  for (const NumberUnit& unit : kNumberUnits) {
    if (numbers.front() < unit.least) continue;
    if (numbers.back() > kMaxStamp / unit.nanoseconds) break;
    warnings->push_back(folder.string() +
                        ": the numbers of the images are taken for their stamps, in " + unit.name);
    std::vector<Stamp> stamps;
    for (const std::int64_t number : numbers) stamps.push_back(number * unit.nanoseconds);
    return stamps;
  }
  warnings->push_back(WithoutStamps(folder, rate));
  return StampsOfNumbers(numbers, rate);
}

}  // namespace

FrameList PairNumberedImages(const std::filesystem::path& folder,
                             const std::map<std::int64_t, std::filesystem::path>& colour,
                             const std::map<std::int64_t, std::filesystem::path>& depth,
                             const DatasetOptions& options) {
  options.Validate();
  FrameList list;
  std::vector<std::int64_t> numbers;
  for (const auto& [number, file] : colour) numbers.push_back(number);
  const std::vector<Stamp> stamps = StampsOf(folder, numbers, options.frame_rate, &list.warnings);
  std::size_t i = 0;
  for (const auto& [number, file] : colour) {
    const Stamp stamp = stamps[i++];
    const auto other = depth.find(number);
    if (other == depth.end()) {
      list.without_depth.push_back(stamp);
      continue;
    }
    list.frames.push_back({.stamp = stamp,
                           .colour = file,
                           .number = static_cast<std::size_t>(number),
                           .depth = other->second});
  }
  return list;
}

}  // namespace highwall
