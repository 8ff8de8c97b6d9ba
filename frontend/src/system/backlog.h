#pragma once

#include <cstddef>

#include <highwall/frontend/system/slam_system.h>
#include <highwall/frontend/tracking/options.h>

namespace highwall {

// The images that wait to be tracked, and what is postponed while there are any
// (SlamSystem::SetBacklog).
class Backlog {
 public:
  void Set(std::size_t images) { images_ = images; }
  bool IsEmpty() const { return images_ == 0; }

  // Returns whether a keyframe that is due waits until the running adjustment ends: too little
  // would be tracked otherwise, or the last one is long ago. even_if_empty: whether images wait or
  // not. support: of the frame (Support). since_keyframe: [s].
  bool PostponesKeyframe(bool even_if_empty, int support, double since_keyframe,
                         const KeyFramePolicyOptions& due);
  // Returns whether no loop is searched for a new keyframe: at most two keyframes in a row, since
  // the next one is near the same place.
  bool SkipsLoopSearch();

  const PostponedWork& postponed() const { return postponed_; }

 private:
  std::size_t images_ = 0;
  int skipped_in_a_row_ = 0;
  PostponedWork postponed_;
};

}  // namespace highwall
