#include <highwall/internal/quiet_glog.h>

#include <mutex>

#include <glog/logging.h>

namespace highwall::internal {
namespace {

// State of the process-wide log level.
struct Level {
  std::mutex mutex;
  int quiet = 0;   // number of existing QuietGlog objects
  int before = 0;  // level before the first of them
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
