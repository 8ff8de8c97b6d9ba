#pragma once

#include <cstddef>
#include <vector>

#include "abused_sequence.h"

// Frames that are missing, late, or of another place.
namespace highwall::bench {

// The first of every n frames; n >= 1.
OrderChange EveryNth(std::size_t n);

// Again and again 1.5 s that are shown and a gap of so many seconds.
OrderChange Gaps(double seconds);

// The depth of a frame is that of `frames` frames before, of the first one where there is none.
OrderChange DepthLags(std::size_t frames);

// Neighbours change places, on average one frame in `every` with the next; the stamps stay. Each is
// judged by where its images were taken. every >= 1.
OrderChange SwappedFrames(double every);

// One frame in `every` on average, but the first, shows the images before once more; the camera
// has moved on, and is looked for where it was at the stamp. every >= 1.
OrderChange DoubledFrames(double every);

// The camera is taken away in the middle of the sequence, for as long as `elsewhere` lasts, and put
// back. elsewhere: at least two frames of another recording.
OrderChange CutIn(std::vector<AbusedFrame> elsewhere);

}  // namespace highwall::bench
