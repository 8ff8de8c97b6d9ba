#pragma once

#include <span>
#include <string>
#include <vector>

#include <highwall/core/stamp.h>
#include <highwall/frontend/input/dataset.h>

namespace [[gnu::visibility("default")]] highwall {

enum class StampFindingKind {
  kEqual,         // several images have one stamp
  kDecreasing,    // a stamp is smaller than the one before
  kFrameNumbers,  // 0, 1, 2 ...
  kUnit,          // they are far apart or near together: in another unit than seconds
  kBursts,        // several images at a time: when they arrived
  kPairsApart,  // depth was taken a frame earlier or later than the colour image it is paired with
};

struct StampFinding {
  StampFindingKind kind = StampFindingKind::kUnit;
  std::string text;    // one line for people
  std::string remedy;  // likewise: what to do
};

// Checks the stamps of the frames of a recording, in their order; depth_delays [ns]: of the depth
// images after their colour images, in the same order, or empty. A camera takes 1 to 240 images per
// second, and its intervals are equal except for frames that are left out: the unit is judged by
// their median. Frames a second apart from a stamp near zero on are frame numbers, or a time lapse
// whose clock began at zero: nothing in the stamps tells which, and the remedy names both. From a
// date on they are a time lapse. The result is empty if there is nothing to say, and for fewer than
// ten frames.
std::vector<StampFinding> CheckStamps(std::span<const Stamp> stamps,
                                      std::span<const Stamp> depth_delays = {});

// Does the same for all frames of a dataset.
std::vector<StampFinding> CheckStamps(const Dataset& dataset);

}  // namespace highwall
