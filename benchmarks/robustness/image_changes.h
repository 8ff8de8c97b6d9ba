#pragma once

#include <cstddef>

#include "abused_sequence.h"

// Colour images of a worse camera. Light is linear in (grey level / 255)^2.2.
namespace highwall::bench {

// Every frame is blurred along a straight way of so many pixels, > 0, in a direction of its own;
// what is averaged is light.
ImageChange MotionBlur(double pixels);

// Grey levels become 255 (level / 255)^gamma, with one of two exponents > 0: for `spell` frames the
// one, for as many the other. spell >= 1.
ImageChange GammaJumps(double low, double high, std::size_t spell);

// The same with an exponent of each frame's own, its logarithm uniform between the two.
ImageChange RandomGamma(double low, double high);

// The light is multiplied by a gain of each spell's own, its logarithm uniform between the two, >
// 0; what is then too bright is 255. spell: frames, >= 1.
ImageChange ExposureJumps(double low, double high, std::size_t spell);

// Gaussian, of each pixel and channel its own. sigma: grey levels, > 0.
ImageChange ColourNoise(double sigma);

// Something before the lens that is too near for any depth: half of the image is next to black, 4
// grey levels with a noise of 2. Which half is drawn for the first `spell` frames, >= 1; it goes on
// from left to right, upper, lower half and left again.
ImageChange HalfCovered(std::size_t spell);

}  // namespace highwall::bench
