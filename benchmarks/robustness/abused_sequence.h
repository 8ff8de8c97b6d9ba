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

// A frame of a changed sequence: which recorded images it shows, and when.
struct AbusedFrame {
  const Dataset* images = nullptr;
  std::size_t colour = 0, depth = 0;  // frames of `images`
  Stamp stamp = 0;                    // what the camera says
  // In the clock of `images`: the camera was then where the pose of this frame is looked for.
  Stamp seen = 0;
};

// The first `count` frames of a dataset, all of them where it has fewer. dataset: must outlive
// them.
std::vector<AbusedFrame> FramesOf(const Dataset& dataset, std::size_t count = SIZE_MAX);

// Leaves frames out, or has them show others; stamps must ascend. A pure function.
using OrderChange = std::function<std::vector<AbusedFrame>(std::vector<AbusedFrame> frames,
                                                           const simulate::CounterRandom& random)>;

// Spoils the images of frame `frame` of the changed sequence, in place. A pure function: the same
// image, frame and random numbers give the same bytes.
using ImageChange =
    std::function<void(std::size_t frame, const simulate::CounterRandom& random, RgbdImage* image)>;

// A way to spoil a recording. Either change may be empty.
struct Abuse {
  std::string name;
  OrderChange order;
  ImageChange image;
};

// A recording as it would have been with such a camera. Frames change when they are loaded, by the
// seed and their index alone; nothing is written.
class AbusedSequence final : public Dataset {
 public:
  // frames: of a recording, not empty; that of the first of them is the one that is scored: what an
  // abuse cuts in from others is elsewhere. Throws InvalidArgument where the abuse leaves no frame
  // or stamps that do not ascend.
  AbusedSequence(std::vector<AbusedFrame> frames, const Abuse& abuse, std::uint64_t seed);

  std::size_t size() const override { return frames_.size(); }
  Stamp stamp(std::size_t index) const override { return frames_[index].stamp; }
  // The pose of each frame that has one within 20 ms of when it was seen, at the frame's stamp;
  // none of those elsewhere. Null where the recording has none.
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
