#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <highwall/core/stamp.h>
#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/dataset.h>
#include <simulate/random.h>

namespace highwall::bench {

// Frame of a modified sequence: the recorded images it shows, and its time.
struct AbusedFrame {
  const Dataset* images = nullptr;
  std::size_t colour = 0, depth = 0;  // frames of `images`
  Stamp stamp = 0;                    // as reported by the camera
  // In the clock of `images`: time of the ground-truth pose of this frame.
  Stamp seen = 0;
};

// Returns the first `count` frames of a dataset, or all if it has fewer. dataset: must outlive
// them.
std::vector<AbusedFrame> FramesOf(const Dataset& dataset, std::size_t count = SIZE_MAX);

// Removes frames or replaces their images; stamps must ascend. A pure function.
using OrderChange = std::function<std::vector<AbusedFrame>(std::vector<AbusedFrame> frames,
                                                           const simulate::CounterRandom& random)>;

// Degrades the images of frame `frame` of the modified sequence, in place. A pure function: the
// same image, frame and random numbers give the same bytes.
using ImageChange =
    std::function<void(std::size_t frame, const simulate::CounterRandom& random, RgbdImage* image)>;

// A way to degrade a recording. Either change may be empty.
struct Abuse {
  std::string name;
  OrderChange order;
  ImageChange image;
};

// Recording with a simulated degradation. Frames are modified when loaded, depending only on the
// seed and their index; nothing is written.
class AbusedSequence final : public Dataset {
 public:
  // frames: of a recording, not empty. The dataset of the first one is scored; frames inserted from
  // others count as elsewhere. Throws InvalidArgument if the abuse leaves no frame, or stamps that
  // do not ascend.
  AbusedSequence(std::vector<AbusedFrame> frames, const Abuse& abuse, std::uint64_t seed);

  std::size_t size() const override { return frames_.size(); }
  Stamp stamp(std::size_t index) const override { return frames_[index].stamp; }
  // Returns the pose of each frame that has one within 20 ms of `seen`, at the frame's stamp; none
  // for frames elsewhere. Null if the recording has none.
  const Trajectory* groundtruth() const override { return groundtruth_ ? &*groundtruth_ : nullptr; }

  const std::vector<AbusedFrame>& frames() const { return frames_; }
  bool IsElsewhere(std::size_t index) const { return frames_[index].images != home_; }

 private:
  RgbdImage DoLoad(std::size_t index) const override;
  void FindGroundtruth(const Trajectory& groundtruth);

  const Dataset* home_;
  std::vector<AbusedFrame> frames_;
  ImageChange change_;
  simulate::CounterRandom random_;
  std::optional<Trajectory> groundtruth_;
};

}  // namespace highwall::bench
