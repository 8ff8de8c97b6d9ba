#pragma once

#include <cstddef>

#include "abused_sequence.h"

// Depth images of a worse sensor; colour stays.
namespace highwall::bench {

// Takes so large a share of a frame's readings, in [0, 1]. What goes lies, as that of real sensors,
// along edges of the depth, of holes that are there already too, and in blobs: readings go in the
// order of a score that is 1 on an edge and falls by a factor e every 8 px away from it, plus a
// smooth random field between 0 and 1 with blobs of some 32 px that last for about 15 frames.
ImageChange DepthHoles(double share);

// What is farther than `metres` is not measured.
ImageChange DepthCut(double metres);

// No depth from frame `frame` on.
ImageChange NoDepthFrom(std::size_t frame);

// Gaussian, of each reading z [m] its own. quadratic: sigma over z^2, > 0 [1/m].
ImageChange DepthNoiseOf(double quadratic);

}  // namespace highwall::bench
