#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <string>
#include <thread>

#include <highwall/internal/stopwatch.h>

namespace highwall::apps {

// Returns "label  120/798  15%  31.2/s  22 s left"; without a total: "label  120  31.2/s"; without
// a count: "label  22 s".
std::string FormatProgress(const std::string& label, std::size_t done, std::size_t total,
                           double elapsed_seconds);

// Reports the progress of a long task on standard error during its lifetime: on a terminal one line
// that is rewritten in place and finally erased, elsewhere a line every ten seconds, "... label
// 120/798". A separate thread writes, so that a task without a count is reported as well.
class Progress {
 public:
  // interval: between lines if standard error is not a terminal.
  explicit Progress(std::string label,
                    std::chrono::milliseconds interval = std::chrono::seconds(10));
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // total: 0 if unknown.
  void Update(std::size_t done, std::size_t total = 0);
  // Prints a line of its own on standard error.
  void Print(const std::string& line);
  // Starts a new stage, counted from zero.
  void Begin(std::string label);

 private:
  void Run(std::chrono::milliseconds interval);

  const bool on_terminal_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ended_ = false;
  std::string label_;
  std::size_t done_ = 0, total_ = 0;
  Stopwatch since_begin_;
  std::thread writer_;
};

}  // namespace highwall::apps
