#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include <highwall/core/stamp.h>
#include <highwall/factors/imu_buffer.h>

namespace [[gnu::visibility("default")]] highwall {

// Readings of an IMU between the thread that they arrive on and the one that uses them. The oldest
// of very many are dropped.
class ImuInbox {
 public:
  void Add(std::span<const ImuSample> readings);
  // Returns the readings that were not returned before.
  std::vector<ImuSample> Take();
  // Waits for a reading of this stamp or a later one; for a short time, and not at all once an IMU
  // has been waited for in vain, until it is heard again.
  void WaitFor(Stamp stamp);
  // Nobody waits any longer.
  void Close();

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<ImuSample> readings_;
  std::optional<Stamp> newest_;
  bool silent_ = false;
  bool closed_ = false;
};

}  // namespace highwall
