#include "cli/progress.h"

#include <unistd.h>

#include <cstdio>
#include <utility>

#include <fmt/format.h>

#include <highwall/internal/run_profile.h>

namespace highwall::apps {
namespace {

constexpr const char* kEraseLine = "\r\033[K";

}  // namespace

std::string FormatProgress(const std::string& label, std::size_t done, std::size_t total,
                           double elapsed_seconds) {
  if (done == 0 && total == 0) return label + fmt::format("  {:.0f} s", elapsed_seconds);
  std::string line = label + "  " + std::to_string(done);
  if (total > 0) {
    line += "/" + std::to_string(total) + "  " + std::to_string(100 * done / total) + "%";
  }
  if (done == 0 || elapsed_seconds <= 0.0) return line;
  const double rate = static_cast<double>(done) / elapsed_seconds;
  line += fmt::format("  {:.1f}/s", rate);
  if (total > done)
    line += fmt::format("  {:.0f} s left", static_cast<double>(total - done) / rate);
  return line;
}

Progress::Progress(std::string label, std::chrono::milliseconds interval)
    : on_terminal_(::isatty(STDERR_FILENO) == 1), label_(std::move(label)) {
  static constexpr std::chrono::milliseconds kRedraw{100};
  writer_ = std::thread([this, interval] {
    SetUpThread({"progress"});
    Run(on_terminal_ ? kRedraw : interval);
  });
}

Progress::~Progress() {
  {
    const std::scoped_lock lock(mutex_);
    ended_ = true;
  }
  wake_.notify_one();
  writer_.join();
  if (on_terminal_) std::fputs(kEraseLine, stderr);
}

void Progress::Update(std::size_t done, std::size_t total) {
  const std::scoped_lock lock(mutex_);
  done_ = done;
  total_ = total;
}

void Progress::Print(const std::string& line) {
  const std::scoped_lock lock(mutex_);
  std::fputs(((on_terminal_ ? kEraseLine : "") + line + "\n").c_str(), stderr);
  std::fflush(stderr);
}

void Progress::Begin(std::string label) {
  const std::scoped_lock lock(mutex_);
  label_ = std::move(label);
  done_ = total_ = 0;
  since_begin_ = Stopwatch();
}

void Progress::Run(std::chrono::milliseconds interval) {
  std::unique_lock lock(mutex_);
  while (!wake_.wait_for(lock, interval, [this] { return ended_; })) {
    const std::string line = FormatProgress(label_, done_, total_, since_begin_.Seconds());
    std::fputs((on_terminal_ ? kEraseLine + line : "... " + line + "\n").c_str(), stderr);
    std::fflush(stderr);
  }
}

}  // namespace highwall::apps
