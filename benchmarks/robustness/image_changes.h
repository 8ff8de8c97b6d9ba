#pragma once

#include <cstddef>

#include "abused_sequence.h"

// Degraded colour images. Light is linear in (grey level / 255)^2.2.
namespace highwall::bench {

// Blurs every frame along a straight line of `pixels` > 0 in a random direction per frame; the
// average is over light.
ImageChange MotionBlur(double pixels);

// Maps grey levels to 255 (level / 255)^gamma, alternating every `spell` frames between two
// exponents > 0. spell >= 1.
ImageChange GammaJumps(double low, double high, std::size_t spell);

// Does the same with a random exponent per frame, its logarithm uniform between the two.
ImageChange RandomGamma(double low, double high);

// Multiplies the light by a random gain per spell, its logarithm uniform between the two, > 0;
// values are clipped at 255. spell: frames, >= 1.
ImageChange ExposureJumps(double low, double high, std::size_t spell);

// Adds independent Gaussian noise to each pixel and channel. sigma: grey levels, > 0.
ImageChange ColourNoise(double sigma);

// Covers half of the image by an object too close for depth measurements: it is almost black, 4
// grey levels with a noise of 2. The half is random for the first `spell` frames, >= 1; it then
// cycles through left, right, upper and lower half.
ImageChange HalfCovered(std::size_t spell);

}  // namespace highwall::bench
