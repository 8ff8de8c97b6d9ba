#include <highwall/frontend/input/frame_queue.h>

#include <utility>

#include <highwall/core/error.h>

namespace highwall {

FrameQueue::FrameQueue(std::size_t capacity) : capacity_(capacity) {
  HIGHWALL_REQUIRE(capacity >= 1, "FrameQueue: the capacity must be at least 1");
}

void FrameQueue::Push(RgbdImage image) {
  {
    const std::lock_guard lock(mutex_);
    if (closed_) {
      ++dropped_;
      return;
    }
    if (images_.size() == capacity_) {
      images_.pop_front();
      ++dropped_;
    }
    images_.push_back(std::move(image));
  }
  changed_.notify_one();
}

void FrameQueue::Close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  changed_.notify_all();
}

std::optional<RgbdImage> FrameQueue::Pop() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return closed_ || !images_.empty(); });
  if (images_.empty()) return std::nullopt;
  RgbdImage image = std::move(images_.front());
  images_.pop_front();
  return image;
}

std::size_t FrameQueue::size() const {
  const std::lock_guard lock(mutex_);
  return images_.size();
}

std::size_t FrameQueue::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}

}  // namespace highwall
