#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <string>
#include <thread>

#include <highwall/internal/stopwatch.h>

namespace highwall::apps {

// "label  120/798  15%  31.2/s  22 s left"; without a total: "label  120  31.2/s"; where nothing is
// counted: "label  22 s".
std::string FormatProgress(const std::string& label, std::size_t done, std::size_t total,
                           double elapsed_seconds);

// How far long work has come, on standard error, as long as it lives: on a terminal one line that
// is rewritten in place and erased in the end, elsewhere a line every ten seconds, "... label
// 120/798". A thread of its own writes, so that work in which nothing is counted is told of as
// well.
class Progress {
 public:
  // interval: between the lines where standard error is no terminal.
  explicit Progress(std::string label,
                    std::chrono::milliseconds interval = std::chrono::seconds(10));
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // total: 0 if unknown.
  void Update(std::size_t done, std::size_t total = 0);
  // What is done from now on, counted from nothing.
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
