#include "system/stamp_sequence.h"

#include <string>

#include <highwall/core/error.h>
#include <highwall/frontend/system/slam_system.h>

namespace highwall {

void StampSequence::RequireNext(Stamp stamp) {
  HIGHWALL_REQUIRE(stamp <= kMaxStamp && stamp >= -kMaxStamp,
                   "SlamSystem::Track: stamp " + std::to_string(stamp) +
                       " ns is beyond 146 years: leave the frame out, or check the clock's unit");
  if (!last_) return;
  HIGHWALL_REQUIRE(stamp > *last_, "SlamSystem::Track: stamp " + FormatStamp(stamp) +
                                       " is not after " + FormatStamp(*last_));
  const auto is_near = [&](Stamp before) {
    return stamp >= before && ToSeconds(stamp - before) <= kLongestPause;
  };
  if (is_near(*last_) || (jumped_ && is_near(*jumped_))) {
    jumped_.reset();
    return;
  }
  jumped_ = stamp;
  throw InvalidArgument("SlamSystem::Track: stamp " + FormatStamp(stamp) +
                        " is more than a day after " + FormatStamp(*last_) +
                        ": skip the frame and continue with the next if its clock is wrong; if the "
                        "camera did pause, pass the frame again");
}

}  // namespace highwall
