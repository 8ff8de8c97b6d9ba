#include <highwall/frontend/input/frame_reader.h>

#include <algorithm>
#include <utility>

#include <highwall/internal/stage_timer.h>

namespace highwall {

FrameReader::FrameReader(const Dataset& dataset, const FrameReaderOptions& options)
    : dataset_(dataset),
      begin_(std::min(options.begin, dataset.size())),
      end_(std::clamp(options.end, begin_, dataset.size())),
      prefetch_(options.prefetch),
      profile_(options.profile),
      next_load_(begin_) {
  if (prefetch_ > 0) {
    thread_ = std::jthread([this](const std::stop_token& stop) {
      const ThreadLabel label{"decoding", profile_};
      SetUpThread(label);
      const ProfiledThread profiled(label);
      Prefetch(stop);
    });
  }
}

std::optional<RgbdImage> FrameReader::Next() {
  if (position_ == count()) return std::nullopt;
  Slot slot;
  if (prefetch_ == 0) {
    slot = LoadNext();
  } else {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !queue_.empty(); });
    // An end or an error stays in the queue: nothing follows it.
    slot = queue_.front();
    if (slot.image) queue_.pop_front();
  }
  changed_.notify_all();
  if (slot.error) std::rethrow_exception(slot.error);
  position_ = std::min(slot.index + 1, end_) - begin_;
  return std::move(slot.image);
}

FrameReader::Slot FrameReader::LoadNext() {
  const DecodingTimer timer(profile_);
  while (next_load_ < end_) {
    const std::size_t index = next_load_++;
    if (std::optional<RgbdImage> image = dataset_.Load(index)) return {index, std::move(image), {}};
  }
  return {end_, std::nullopt, {}};
}

void FrameReader::Prefetch(const std::stop_token& stop) {
  bool more = true;
  while (more && !stop.stop_requested()) {
    Slot slot;
    try {
      slot = LoadNext();
    } catch (...) {
      slot.error = std::current_exception();
    }
    more = slot.image.has_value();
    std::unique_lock lock(mutex_);
    if (!changed_.wait(lock, stop, [this] { return queue_.size() < prefetch_; })) return;
    queue_.push_back(std::move(slot));
    lock.unlock();
    changed_.notify_all();
  }
}

}  // namespace highwall
