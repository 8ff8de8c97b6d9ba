#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <highwall/core/stamp.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/frame_reader.h>

#include "run/live_replay.h"

namespace highwall::apps {

// Frames of a dataset, on request or at the pace of their stamps.
class FrameSource {
 public:
  // dataset and options.profile must outlive the source.
  FrameSource(const Dataset& dataset, const FrameReaderOptions& options, bool live);

  std::optional<RgbdImage> Next();
  // Number of frames due so far, including unusable and dropped ones.
  std::size_t position() const { return live_ ? live_->position() : reader_->position(); }
  std::size_t count() const { return live_ ? live_->count() : reader_->count(); }
  std::size_t dropped() const { return live_ ? live_->dropped() : 0; }
  // Number of frames after the last one returned.
  std::size_t left() const;
  // Number of frames that are late.
  std::size_t waiting() const { return live_ ? live_->waiting() : 0; }

  // Measures the time since the frame of this stamp arrived, if frames come at their pace.
  void Measure(Stamp stamp);
  // [ms] from the arrival of each frame to its result.
  const std::vector<double>& delays() const { return delays_; }

 private:
  RunProfile* const profile_;
  std::optional<FrameReader> reader_;  // one of the two
  std::optional<LiveReplay> live_;
  std::vector<double> delays_;
};

}  // namespace highwall::apps
