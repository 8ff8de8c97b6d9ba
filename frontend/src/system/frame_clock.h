#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <highwall/core/stamp.h>

namespace highwall {

// Time between frames for the rules that count in seconds of a camera. Where frames are a second or
// more apart, their stamps are frame numbers or in another unit, or the recording is a time lapse:
// these rules then count frames, as of a camera at 30 Hz.
class FrameClock {
 public:
  // Takes the stamp of the next frame.
  void Add(Stamp stamp);
  // Returns the time [s] between two stamps. Within the first frames it is that of the stamps.
  double Seconds(Stamp from, Stamp to) const { return scale_ * ToSeconds(to - from); }

 private:
  std::optional<Stamp> last_;
  std::vector<Stamp> intervals_;  // the latest, in a ring
  std::size_t next_ = 0;          // place of the next interval
  double scale_ = 1.0;
};

}  // namespace highwall
