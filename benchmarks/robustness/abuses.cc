#include "abuses.h"

#include <cstddef>

#include "depth_changes.h"
#include "frame_order.h"
#include "image_changes.h"

namespace highwall::bench {

std::vector<Abuse> AllAbuses(const Dataset* second) {
  // [frames]; half a second and a second at 30 Hz.
  constexpr std::size_t kShortSpell = 15, kLongSpell = 30, kAlways = SIZE_MAX;
  constexpr std::size_t kKidnapped = 150;  // [frames]
  std::vector<Abuse> abuses{
      {"untouched", {}, {}},
      {"every 2nd frame", EveryNth(2), {}},
      {"every 3rd frame", EveryNth(3), {}},
      {"every 4th frame", EveryNth(4), {}},
      {"every 5th frame", EveryNth(5), {}},
      {"every 6th frame", EveryNth(6), {}},
      {"every 7th frame", EveryNth(7), {}},
      {"every 8th frame", EveryNth(8), {}},
      {"every 9th frame", EveryNth(9), {}},
      {"every 10th frame", EveryNth(10), {}},
      {"gaps of 0.5 s", Gaps(0.5), {}},
      {"gaps of 1 s", Gaps(1.0), {}},
      {"gaps of 2 s", Gaps(2.0), {}},
      {"gaps of 5 s", Gaps(5.0), {}},
      {"blur 7 px", {}, MotionBlur(7.0)},
      {"blur 15 px", {}, MotionBlur(15.0)},
      {"blur 30 px", {}, MotionBlur(30.0)},
      {"gamma 0.4 and 2.5 by turns", {}, GammaJumps(0.4, 2.5, kShortSpell)},
      {"gamma 0.4 to 2.5 each frame", {}, RandomGamma(0.4, 2.5)},
      {"exposure 1/8 to 8", {}, ExposureJumps(0.125, 8.0, kShortSpell)},
      {"noise 10", {}, ColourNoise(10.0)},
      {"noise 25", {}, ColourNoise(25.0)},
      {"half covered", {}, HalfCovered(kAlways)},
      {"half covered, another half every s", {}, HalfCovered(kLongSpell)},
      {"depth holes 10 %", {}, DepthHoles(0.1)},
      {"depth holes 30 %", {}, DepthHoles(0.3)},
      {"depth holes 60 %", {}, DepthHoles(0.6)},
      {"depth holes 80 %", {}, DepthHoles(0.8)},
      {"depth holes 90 %", {}, DepthHoles(0.9)},
      {"depth to 1 m", {}, DepthCut(1.0)},
      {"no depth from frame 50", {}, NoDepthFrom(50)},
      {"depth noise 5 mm at 1 m", {}, DepthNoiseOf(0.005)},
      {"depth 1 frame late", DepthLags(1), {}},
      {"depth 2 frames late", DepthLags(2), {}},
      {"depth 3 frames late", DepthLags(3), {}},
      {"swapped frames", SwappedFrames(5.0), {}},
      {"doubled frames", DoubledFrames(5.0), {}},
  };
  if (second != nullptr) abuses.push_back({"kidnapped", CutIn(FramesOf(*second, kKidnapped)), {}});
  return abuses;
}

}  // namespace highwall::bench
