#pragma once

#include <optional>

#include <highwall/core/stamp.h>

namespace highwall {

// The stamps of the frames of SlamSystem::Track(): checks that each may follow those before.
class StampSequence {
 public:
  // Throws InvalidArgument if the stamp cannot be that of the next frame: it does not ascend, is
  // beyond kMaxStamp, or is more than kLongestPause after the last one. The latter is thrown only
  // once: the same stamp again, or one that follows it, is accepted.
  void RequireNext(Stamp stamp);
  // The frame counts from now on.
  void Accept(Stamp stamp) { last_ = stamp; }

 private:
  std::optional<Stamp> last_;
  std::optional<Stamp> jumped_;  // the last stamp that was rejected because it jumped
};

}  // namespace highwall
