#include "progress.h"

#include <unistd.h>

#include <array>
#include <cstdio>
#include <utility>

namespace highwall::apps {
namespace {

template <typename... Values>
std::string Format(const char* format, Values... values) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

constexpr const char* kEraseLine = "\r\033[K";

}  // namespace

std::string FormatProgress(const std::string& label, std::size_t done, std::size_t total,
                           double elapsed_seconds) {
  std::string line = label + "  " + std::to_string(done);
  if (total > 0) {
    line += "/" + std::to_string(total) + "  " + std::to_string(100 * done / total) + "%";
  }
  if (done == 0 || elapsed_seconds <= 0.0) return line;
  const double rate = static_cast<double>(done) / elapsed_seconds;
  line += Format("  %.1f/s", rate);
  if (total > done) line += Format("  %.0f s left", static_cast<double>(total - done) / rate);
  return line;
}

Progress::Progress(std::string label)
    : label_(std::move(label)), enabled_(::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (enabled_) std::fputs(kEraseLine, stderr);
}

void Progress::Update(std::size_t done, std::size_t total) {
  constexpr double kInterval = 100.0;  // [ms]
  if (!enabled_ || since_drawn_.Milliseconds() < kInterval) return;
  since_drawn_ = Stopwatch();
  const double elapsed = since_start_.Seconds();
  std::fputs((kEraseLine + FormatProgress(label_, done, total, elapsed)).c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace highwall::apps
