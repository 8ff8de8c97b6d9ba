#pragma once

namespace [[gnu::visibility("default")]] highwall {
namespace internal {

// While one lives, glog prints nothing but what ends the program: Ceres writes why a step failed to
// standard error, whatever it is told. Any thread may have one.
class QuietGlog {
 public:
  QuietGlog();
  ~QuietGlog();
  QuietGlog(const QuietGlog&) = delete;
  QuietGlog& operator=(const QuietGlog&) = delete;
};

}  // namespace internal
}  // namespace highwall
