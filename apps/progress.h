#pragma once

#include <cstddef>
#include <string>

#include <highwall/internal/stopwatch.h>

namespace highwall::apps {

// "label  120/798  15%  31.2/s  22 s left"; without a total: "label  120  31.2/s".
std::string FormatProgress(const std::string& label, std::size_t done, std::size_t total,
                           double elapsed_seconds);

// One line on standard error that is rewritten in place during long work; nothing at all where
// standard error is no terminal. The line is erased in the end.
class Progress {
 public:
  explicit Progress(std::string label);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // total: 0 if unknown. Cheap: draws at most ten times a second.
  void Update(std::size_t done, std::size_t total = 0);

 private:
  std::string label_;
  bool enabled_;
  Stopwatch since_start_, since_drawn_;
};

}  // namespace highwall::apps
