#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>

#include <highwall/frontend/input/dataset.h>

namespace [[gnu::visibility("default")]] highwall {

// Queue of images from a camera that does not wait to a consumer that may be slower: an image that
// arrives at a full queue replaces the oldest one. Push() on the thread of the camera, Pop() on
// that of the consumer. (A recording can wait: FrameReader.)
class FrameQueue {
 public:
  // capacity: maximum number of waiting images, >= 1. Keep it small: an image that has waited is
  // late.
  explicit FrameQueue(std::size_t capacity = 2);

  // Never blocks. After Close() the image is dropped.
  void Push(RgbdImage image);
  // Announces that no more images will come: Pop() returns the remaining ones and then nothing.
  void Close();
  // Returns the oldest image; waits for one. Empty after the last image of a closed queue.
  std::optional<RgbdImage> Pop();
  // Number of images that wait (SlamSystem::SetBacklog).
  std::size_t size() const;
  // Number of images that were dropped.
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
