#include "run/live_replay.h"

#include <utility>

namespace highwall::apps {

LiveReplay::LiveReplay(const Dataset& dataset, const FrameReaderOptions& options, double rate)
    : rate_(rate),
      reader_(dataset, options),
      thread_(
          [this, label = ThreadLabel{"live replay", options.profile}](const std::stop_token& stop) {
            SetUpThread(label);
            const ProfiledThread profiled(label);
            Play(stop);
          }) {}

std::optional<RgbdImage> LiveReplay::Next() {
  std::optional<RgbdImage> image = queue_.Pop();
  if (!image && error_) std::rethrow_exception(error_);
  return image;
}

void LiveReplay::Play(const std::stop_token& stop) {
  try {
    while (std::optional<RgbdImage> image = reader_.Next()) {
      if (!first_) {
        first_ = image->stamp;
        start_ = Clock::now();
      }
      if (!WaitUntil(Due(image->stamp), stop)) break;
      position_ = reader_.position();
      queue_.Push(*std::move(image));
    }
  } catch (...) {
    error_ = std::current_exception();
  }
  position_ = reader_.position();
  queue_.Close();
}

LiveReplay::Clock::time_point LiveReplay::Due(Stamp stamp) const {
  const double since = static_cast<double>(stamp - *first_) / rate_;
  return start_ + std::chrono::nanoseconds(static_cast<Stamp>(since));
}

double LiveReplay::MillisecondsSince(Stamp stamp) const {
  return std::chrono::duration<double, std::milli>(Clock::now() - Due(stamp)).count();
}

bool LiveReplay::WaitUntil(Clock::time_point due, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, stop, due, [] { return false; });
  return !stop.stop_requested();
}

}  // namespace highwall::apps
