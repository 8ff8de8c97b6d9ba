#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

#include <highwall/frontend/input/frame_queue.h>
#include <highwall/frontend/input/frame_reader.h>

namespace highwall::apps {

// Replays a recording as a live camera: frames arrive at the pace of their stamps, whether or not
// the consumer is ready.
class LiveReplay {
 public:
  // dataset: must outlive the replay. rate: > 0, of the pace of the stamps; 2: twice as fast.
  LiveReplay(const Dataset& dataset, const FrameReaderOptions& options, double rate = 1.0);

  // Waits for the next frame; empty at the end. Rethrows an exception that stopped the reader.
  std::optional<RgbdImage> Next();
  // Number of frames due so far, including unusable and dropped ones.
  std::size_t position() const { return position_; }
  std::size_t count() const { return reader_.count(); }
  std::size_t dropped() const { return queue_.dropped(); }
  std::size_t waiting() const { return queue_.size(); }
  // Returns the time [ms] since the frame of this stamp was due; only after Next() returned it.
  double MillisecondsSince(Stamp stamp) const;

 private:
  using Clock = std::chrono::steady_clock;

  void Play(const std::stop_token& stop);
  // Returns false if a stop was requested.
  bool WaitUntil(Clock::time_point due, const std::stop_token& stop);
  // Returns when the frame of this stamp arrives.
  Clock::time_point Due(Stamp stamp) const;

  const double rate_;
  FrameReader reader_;
  FrameQueue queue_;
  std::atomic<std::size_t> position_ = 0;
  std::exception_ptr error_;
  // Of the first frame; written before it enters the queue.
  std::optional<Stamp> first_;
  Clock::time_point start_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::jthread thread_;  // last: it uses all of the above and is joined first
};

}  // namespace highwall::apps
