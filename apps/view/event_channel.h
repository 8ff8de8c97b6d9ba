#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace highwall::apps {

// An event of the page (docs/view.md): its name and its data, one line, shared by all clients.
struct ViewEvent {
  std::string name;
  std::shared_ptr<const std::string> data;
};

// Events that wait for one client, at most kCapacity: a new one replaces the oldest, which is
// counted. Not thread-safe.
class EventChannel {
 public:
  static constexpr std::size_t kCapacity = 4;

  void Push(ViewEvent event) {
    if (events_.size() == kCapacity) {
      events_.pop_front();
      ++dropped_;
    }
    events_.push_back(std::move(event));
  }
  std::optional<ViewEvent> Pop() {
    if (events_.empty()) return std::nullopt;
    ViewEvent event = std::move(events_.front());
    events_.pop_front();
    return event;
  }

  std::size_t size() const { return events_.size(); }
  std::uint64_t dropped() const { return dropped_; }

 private:
  std::deque<ViewEvent> events_;
  std::uint64_t dropped_ = 0;
};

}  // namespace highwall::apps
