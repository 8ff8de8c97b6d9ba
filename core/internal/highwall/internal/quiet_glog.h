#pragma once

namespace [[gnu::visibility("default")]] highwall {
namespace internal {

// Suppresses all output of glog below FATAL during its lifetime: Ceres prints the reason of a
// failed step to standard error regardless of its options. Any thread may create one.
class QuietGlog {
 public:
  QuietGlog();
  ~QuietGlog();
  QuietGlog(const QuietGlog&) = delete;
  QuietGlog& operator=(const QuietGlog&) = delete;
};

}  // namespace internal
}  // namespace highwall
