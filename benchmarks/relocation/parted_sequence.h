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
  bool twins = false;  // two rooms that look alike, else parts of one room
  std::uint64_t seed = 1;
  double fps = 30.0;   // [Hz] > 0
  double scale = 1.0;  // of the image, 1 = 640 x 480
};

// A walk in parts: the images on disk, the truth in memory.
class WalkInParts {
 public:
  // Renders the images into a folder of `cache`, unless an earlier run has done so. The folder's
  // name tells the options, not the version of the simulator. progress(done, total). Throws
  // IoError.
  WalkInParts(const WalkOptions& options, const std::filesystem::path& cache,
              const std::function<void(int, int)>& progress);

  // What an estimator should take the camera for.
  RgbdSensor sensor() const;
  std::size_t size() const { return images_->size(); }
  RgbdImage Load(std::size_t frame) const;
  Stamp stamp(std::size_t frame) const { return images_->stamp(frame); }
  Pose T_WC(std::size_t frame) const { return parted_.simulation.T_WC(stamp(frame)); }
  std::uint64_t seed() const { return options().seed; }
  // Which part the frame is of: 0, 1, ...; none on the way from one to the next.
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

// What a parted sequence makes of the ways between the parts.
enum class Ways {
  kShown,    // nobody is kidnapped
  kLeftOut,  // the stamps close up
  kCovered,  // the lens is
  // They are left out, and the parts of a kidnap are put into an order, one of them backwards where
  // need be, in which each begins where the one before has been: the same images, and no place that
  // is not known.
  kNotNeeded,
};

// What the sensor reads behind a cover.
enum class Cover {
  kEmpty,    // no depth
  kNear,     // the cover's
  kGarbage,  // anything
};

struct PartedFrame {
  std::size_t source = 0;  // of the sequence
  Stamp stamp = 0;
  std::optional<int> part;  // none on the way
};

// The frames of a sequence as a parted sequence shows them.
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
