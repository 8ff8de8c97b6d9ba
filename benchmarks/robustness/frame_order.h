#pragma once

#include <cstddef>
#include <vector>

#include "abused_sequence.h"

// Missing, late, or replaced frames.
namespace highwall::bench {

// Keeps the first of every n frames; n >= 1.
OrderChange EveryNth(std::size_t n);

// Repeats 1.5 s with frames and a gap of `seconds`.
OrderChange Gaps(double seconds);

// Replaces the depth of a frame by that of `frames` frames before, or of the first one if there is
// none.
OrderChange DepthLags(std::size_t frames);

// Swaps neighbouring frames, on average one frame in `every` with the next; the stamps stay. Each
// is scored at the pose where its images were taken. every >= 1.
OrderChange SwappedFrames(double every);

// Repeats the previous images in one frame in `every` on average, except the first; the camera has
// moved, and the frame is scored at the pose of its stamp. every >= 1.
OrderChange DoubledFrames(double every);

// Inserts `elsewhere` in the middle of the sequence: the camera is moved away and back. elsewhere:
// at least two frames of another recording.
OrderChange CutIn(std::vector<AbusedFrame> elsewhere);

}  // namespace highwall::bench
