// Linked into whatever ThreadSanitizer watches: OpenCV's loops stay on the thread that begins them.
// They would share their work by TBB, which is not instrumented, so that all they touch looked
// unordered. The project's own threads are what is watched.
#include <opencv2/core/utility.hpp>

namespace {

[[maybe_unused]] const bool on_one_thread = [] {
  cv::setNumThreads(1);
  return true;
}();

}  // namespace
