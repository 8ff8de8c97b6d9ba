#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>

#include <highwall/frontend/input/dataset.h>

namespace [[gnu::visibility("default")]] highwall {

// Images on their way from a camera that does not wait to somebody who takes his time: what comes
// to a full queue takes the place of the oldest. Push() on the thread of the camera, Pop() on that
// of the user. (A recording waits: FrameReader.)
class FrameQueue {
 public:
  // capacity: images that wait at most, >= 1. Small: what has waited is late.
  explicit FrameQueue(std::size_t capacity = 2);

  // Never waits. After Close() the image is dropped.
  void Push(RgbdImage image);
  // No more images will come: Pop() gives what is left and then nothing.
  void Close();
  // The oldest image; waits for one. Empty when there will be none.
  std::optional<RgbdImage> Pop();
  // Images that nobody got.
  std::size_t dropped() const;

 private:
  const std::size_t capacity_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<RgbdImage> images_;
  std::size_t dropped_ = 0;
  bool closed_ = false;
};

}  // namespace highwall
