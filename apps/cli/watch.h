#pragma once

#include <chrono>
#include <functional>
#include <stop_token>
#include <thread>
#include <utility>

namespace highwall::apps {

// Calls a function once when a condition holds, on a thread of its own, which asks for it every
// 20 ms as long as the object exists.
class Watch {
 public:
  Watch(std::function<bool()> condition, std::function<void()> then)
      : thread_([condition = std::move(condition), then = std::move(then)](std::stop_token stop) {
          while (!stop.stop_requested()) {
            if (condition()) return then();
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
          }
        }) {}

 private:
  std::jthread thread_;
};

}  // namespace highwall::apps
