#include <highwall/internal/quiet_glog.h>

#include <mutex>

#include <glog/logging.h>

namespace highwall::internal {
namespace {

// Of the one level that a process has.
struct Level {
  std::mutex mutex;
  int quiet = 0;   // how many QuietGlog live
  int before = 0;  // what the first of them found
};

Level& TheLevel() {
  static Level level;
  return level;
}

}  // namespace

QuietGlog::QuietGlog() {
  Level& level = TheLevel();
  const std::scoped_lock lock(level.mutex);
  if (level.quiet++ > 0) return;
  level.before = FLAGS_minloglevel;
  FLAGS_minloglevel = google::GLOG_FATAL;
}

QuietGlog::~QuietGlog() {
  Level& level = TheLevel();
  const std::scoped_lock lock(level.mutex);
  if (--level.quiet == 0) FLAGS_minloglevel = level.before;
}

}  // namespace highwall::internal
