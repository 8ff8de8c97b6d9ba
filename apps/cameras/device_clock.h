#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include <highwall/core/stamp.h>

namespace highwall::apps {

// Stamps of a device whose clock counts microseconds from when it was switched on. The first image
// gets the time of the host, so that stamps of several runs do not overlap; from then on the clock
// of the device counts, which knows when images were taken, not when they arrived. A counter of 32
// bits that wraps around is followed. After any other leap the device has restarted, and the clock
// of the host bridges it.
class DeviceClock {
 public:
  using Host = std::chrono::steady_clock;

  // host_stamp: the time of day [ns] of the first image.
  explicit DeviceClock(Stamp host_stamp) : stamp_(host_stamp) {}

  // ticks: [us] of an image that arrives now. Images may be out of order by a second: colour and
  // depth arrive separately.
  Stamp At(std::uint64_t ticks, Host::time_point now);
  // Number of leaps so far.
  int restarts() const { return restarts_; }

 private:
  struct Tick {
    std::uint64_t ticks = 0;
    Host::time_point now{};
  };

  Stamp stamp_;  // of the last image
  std::optional<Tick> last_{};
  int restarts_ = 0;
};

}  // namespace highwall::apps
