#include "abuses.h"

#include <cstddef>
#include <utility>

#include <fmt/core.h>

#include "depth_changes.h"
#include "frame_order.h"
#include "image_changes.h"

namespace highwall::bench {

std::vector<Abuse> AllAbuses(const Dataset* second) {
  constexpr std::size_t kHalfSecond = 15, kAlways = SIZE_MAX, kKidnapped = 150;  // [frames]
  std::vector<Abuse> abuses{{"untouched", {}, {}}};
  const auto order = [&abuses](std::string name, OrderChange change) {
    abuses.push_back({std::move(name), std::move(change), {}});
  };
  const auto image = [&abuses](std::string name, ImageChange change) {
    abuses.push_back({std::move(name), {}, std::move(change)});
  };

  for (const std::size_t n : {2, 3, 4, 5, 6, 7, 8, 9, 10}) {
    order(fmt::format("every {}{} frame", n, n == 2 ? "nd" : n == 3 ? "rd" : "th"), EveryNth(n));
  }
  for (const double s : {0.5, 1.0, 2.0, 5.0}) order(fmt::format("gaps of {} s", s), Gaps(s));
  for (const double px : {7.0, 15.0, 30.0}) image(fmt::format("blur {} px", px), MotionBlur(px));
  image("gamma 0.4 and 2.5 by turns", GammaJumps(0.4, 2.5, kHalfSecond));
  image("gamma 0.4 to 2.5 each frame", RandomGamma(0.4, 2.5));
  image("exposure 1/8 to 8", ExposureJumps(0.125, 8.0, kHalfSecond));
  for (const double grey : {10.0, 25.0}) image(fmt::format("noise {}", grey), ColourNoise(grey));
  image("half covered", HalfCovered(kAlways));
  image("half covered, another half every s", HalfCovered(2 * kHalfSecond));

  for (const int percent : {10, 30, 60, 80, 90}) {
    image(fmt::format("depth holes {} %", percent), DepthHoles(0.01 * percent));
  }
  image("depth to 1 m", DepthCut(1.0));
  image("no depth from frame 50", NoDepthFrom(50));
  image("depth noise 5 mm at 1 m", DepthNoiseOf(0.005));

  order("depth 1 frame late", DepthLags(1));
  for (const std::size_t n : {2, 3}) order(fmt::format("depth {} frames late", n), DepthLags(n));
  order("swapped frames", SwappedFrames(5.0));
  order("doubled frames", DoubledFrames(5.0));
  if (second != nullptr) order("kidnapped", CutIn(FramesOf(*second, kKidnapped)));
  return abuses;
}

}  // namespace highwall::bench
