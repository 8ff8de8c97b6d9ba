#pragma once

#include <chrono>

namespace [[gnu::visibility("default")]] highwall {

// Wall time since it was made, by a clock that nobody sets.
class Stopwatch {
 public:
  double Seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  double Milliseconds() const { return 1e3 * Seconds(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace highwall
