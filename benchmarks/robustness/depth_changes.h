#pragma once

#include <cstddef>

#include "abused_sequence.h"

// Degraded depth images; colour is unchanged.
namespace highwall::bench {

// Removes a share of a frame's readings, in [0, 1]. As with real sensors, the removed readings lie
// along depth edges and existing holes, and in blobs: readings are removed in the order of a score
// that is 1 on an edge and decreases by a factor e every 8 px from it, plus a smooth random field
// between 0 and 1 with blobs of about 32 px that last for about 15 frames.
ImageChange DepthHoles(double share);

// Removes depth farther than `metres`.
ImageChange DepthCut(double metres);

// Removes all depth from frame `frame` on.
ImageChange NoDepthFrom(std::size_t frame);

// Adds independent Gaussian noise to each reading z [m]. quadratic: sigma over z^2, > 0 [1/m].
ImageChange DepthNoiseOf(double quadratic);

}  // namespace highwall::bench
