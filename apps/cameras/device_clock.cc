#include "cameras/device_clock.h"

namespace highwall::apps {
namespace {

constexpr std::int64_t kSecond = 1'000'000;              // [us]
constexpr std::int64_t kWrap = std::int64_t{1} << 32;    // [us]
constexpr std::int64_t kMostAheadOfHost = 10 * kSecond;  // [us] a recording may pause less long
constexpr Stamp kNanoseconds = 1000;                     // of a tick

}  // namespace

Stamp DeviceClock::At(std::uint64_t ticks, Host::time_point now) {
  if (!last_) {
    last_ = Tick{ticks, now};
    return stamp_;
  }
  const std::int64_t host =
      std::chrono::duration_cast<std::chrono::microseconds>(now - last_->now).count();
  auto elapsed = static_cast<std::int64_t>(ticks - last_->ticks);
  const auto is_possible = [host](std::int64_t time) {
    return time >= -kSecond && time <= host + kMostAheadOfHost;
  };
  if (!is_possible(elapsed) && is_possible(elapsed + kWrap)) elapsed += kWrap;
  if (!is_possible(elapsed)) {
    elapsed = host;
    ++restarts_;
  }
  last_ = Tick{ticks, now};
  stamp_ += elapsed * kNanoseconds;
  return stamp_;
}

}  // namespace highwall::apps
