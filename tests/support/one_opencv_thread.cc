// Linked into all programs that run under ThreadSanitizer: OpenCV's loops stay on the calling
// thread. Otherwise OpenCV distributes them by TBB, which is not instrumented, so that all of its
// accesses look unordered. Only the project's own threads are checked.
#include <opencv2/core/utility.hpp>

namespace {

[[maybe_unused]] const bool on_one_thread = [] {
  cv::setNumThreads(1);
  return true;
}();

}  // namespace
