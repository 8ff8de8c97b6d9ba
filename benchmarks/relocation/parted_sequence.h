#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

#include "simulate/scenes/kidnap.h"

namespace highwall::bench {

struct WalkOptions {
  bool twins = false;  // two rooms with similar appearance, otherwise parts of one room
  std::uint64_t seed = 1;
  double fps = 30.0;   // [Hz] > 0
  double scale = 1.0;  // of the image, 1 = 640 x 480
};

// Walk in parts: the images on disk, the ground truth in memory.
class WalkInParts {
 public:
  // Renders the images into a folder of `cache`, unless an earlier run has done so. The folder's
  // name encodes the options, not the version of the simulator. progress(done, total). Throws
  // IoError.
  WalkInParts(const WalkOptions& options, const std::filesystem::path& cache,
              const std::function<void(int, int)>& progress);

  // Returns the camera model for an estimator.
  RgbdSensor sensor() const;
  std::size_t size() const { return images_->size(); }
  RgbdImage Load(std::size_t frame) const;
  Stamp stamp(std::size_t frame) const { return images_->stamp(frame); }
  Pose T_WC(std::size_t frame) const { return parted_.simulation.T_WC(stamp(frame)); }
  std::uint64_t seed() const { return options().seed; }
  // Returns the part of the frame: 0, 1, ...; none on a transition.
  std::optional<int> PartOf(std::size_t frame) const;

 private:
  explicit WalkInParts(const WalkOptions& options, const std::filesystem::path& cache,
                       const std::function<void(int, int)>& progress,
                       simulate::PartedSimulation simulation);

  const simulate::SimulationOptions& options() const { return parted_.simulation.options(); }

  simulate::PartedSimulation parted_;
  std::filesystem::path folder_;
  std::unique_ptr<const Dataset> images_;
};

// Treatment of the transitions between the parts.
enum class Ways {
  kShown,    // no kidnapping
  kLeftOut,  // omitted; the stamps are contiguous
  kCovered,  // the lens is covered
  // Omitted, and the parts of a kidnapping are reordered (one of them reversed if necessary) such
  // that each begins where the previous one has been: the same images, and no unknown place.
  kNotNeeded,
};

// Depth behind a cover.
enum class Cover {
  kEmpty,    // no depth
  kNear,     // that of the cover
  kGarbage,  // arbitrary
};

struct PartedFrame {
  std::size_t source = 0;  // of the sequence
  Stamp stamp = 0;
  std::optional<int> part;  // none on a transition
};

// Frames of a sequence with its transitions treated accordingly.
class PartedSequence {
 public:
  // sequence: must outlive this.
  PartedSequence(const WalkInParts& sequence, Ways ways);

  const WalkInParts& sequence() const { return sequence_; }
  const std::vector<PartedFrame>& frames() const { return frames_; }
  RgbdImage Load(const PartedFrame& frame) const;
  Cover cover() const { return static_cast<Cover>(sequence_.seed() % 3); }
  // T_WC of every frame, at its stamps.
  Trajectory Truth() const;

 private:
  void PutInKnownOrder();
  RgbdImage Covered(const PartedFrame& frame) const;

  const WalkInParts& sequence_;
  Ways ways_;
  std::vector<PartedFrame> frames_;
};

}  // namespace highwall::bench
