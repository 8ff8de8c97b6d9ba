#include <highwall/frontend/input/imu_inbox.h>

#include <algorithm>
#include <chrono>
#include <cstddef>

namespace highwall {
namespace {

constexpr std::chrono::milliseconds kImuTimeout(300);  // for readings that should have arrived
constexpr std::size_t kMostReadings = 20'000;          // that wait for an image

}  // namespace

void ImuInbox::Add(std::span<const ImuSample> readings) {
  if (readings.empty()) return;
  const std::lock_guard lock(mutex_);
  for (const ImuSample& reading : readings) {
    readings_.push_back(reading);
    if (readings_.size() > kMostReadings) readings_.pop_front();
    newest_ = std::max(reading.stamp, newest_.value_or(reading.stamp));
  }
  silent_ = false;
  changed_.notify_all();
}

std::vector<ImuSample> ImuInbox::Take() {
  const std::lock_guard lock(mutex_);
  std::vector<ImuSample> readings(readings_.begin(), readings_.end());
  readings_.clear();
  return readings;
}

void ImuInbox::WaitFor(Stamp stamp) {
  std::unique_lock lock(mutex_);
  const auto is_there = [&] { return closed_ || silent_ || (newest_ && *newest_ >= stamp); };
  if (!changed_.wait_for(lock, kImuTimeout, is_there)) silent_ = true;
}

void ImuInbox::Close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  changed_.notify_all();
}

}  // namespace highwall
