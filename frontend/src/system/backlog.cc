#include "system/backlog.h"

namespace highwall {

bool Backlog::PostponesKeyframe(bool even_if_empty, int support, double since_keyframe,
                                const KeyFramePolicyOptions& due) {
  constexpr double kLongestGaps = 3.0;  // of KeyFramePolicyOptions::max_gap
  if (IsEmpty() && !even_if_empty) return false;
  if (2 * support < due.wanted_tracked || since_keyframe >= kLongestGaps * due.max_gap) {
    return false;
  }
  ++postponed_.keyframes;
  return true;
}

bool Backlog::SkipsLoopSearch() {
  constexpr int kMostInARow = 2;
  if (IsEmpty() || skipped_in_a_row_ == kMostInARow) {
    skipped_in_a_row_ = 0;
    return false;
  }
  ++skipped_in_a_row_;
  ++postponed_.loop_searches;
  return true;
}

}  // namespace highwall
