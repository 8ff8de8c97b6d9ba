#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

#include <highwall/frontend/input/dataset.h>
#include <highwall/internal/run_profile.h>

namespace [[gnu::visibility("default")]] highwall {

struct FrameReaderOptions {
  std::size_t begin = 0;          // first frame read
  std::size_t end = SIZE_MAX;     // one past the last; beyond the dataset: its end
  std::size_t prefetch = 4;       // frames decoded ahead on a thread of their own; 0: no thread
  RunProfile* profile = nullptr;  // records the decoding; null: none; must outlive the reader
};

// Reads the usable frames of a dataset, in order; the skipped ones are in Dataset::problems(). With
// prefetching, decoding overlaps the work of the caller between calls. The frames are the same in
// both cases.
class FrameReader {
 public:
  // dataset: must outlive the reader.
  explicit FrameReader(const Dataset& dataset, const FrameReaderOptions& options = {});
  // Joins the thread; prefetched frames are dropped.
  ~FrameReader() = default;

  // Returns the next usable frame, empty at the end. Rethrows an exception that stopped the thread,
  // such as bad_alloc.
  std::optional<RgbdImage> Next();
  // Number of frames passed, including unusable ones: begin + position() is the next index.
  std::size_t position() const { return position_; }
  // Total number of frames.
  std::size_t count() const { return end_ - begin_; }

 private:
  struct Slot {
    std::size_t index = 0;
    std::optional<RgbdImage> image;  // empty: the end, or an error
    std::exception_ptr error;
  };

  Slot LoadNext();
  void Prefetch(const std::stop_token& stop);

  const Dataset& dataset_;
  std::size_t begin_, end_, prefetch_;
  RunProfile* const profile_;
  std::size_t position_ = 0;
  std::size_t next_load_;  // used by the loading thread only

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<Slot> queue_;
  std::jthread thread_;  // last: it uses all of the above and is joined first
};

}  // namespace highwall
