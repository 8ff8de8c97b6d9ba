#pragma once

#include <memory>

#include <Eigen/Core>

#include "simulate/materials/texture.h"
#include "simulate/random.h"

// Painted faces of a furnished room, composed at random. size: of the face [m], (s, t).
namespace highwall::simulate {

// Returns a saturated colour.
Colour RandomColour(RandomSequence* random);

// Coloured rectangles of all sizes inside a white margin, with lines of text.
std::unique_ptr<const Texture> MakePoster(const Eigen::Vector2d& size, RandomSequence* random);
// A sheet of text under a heading.
std::unique_ptr<const Texture> MakeNotice(const Eigen::Vector2d& size, RandomSequence* random);
// A row of book spines.
std::unique_ptr<const Texture> MakeBooks(const Eigen::Vector2d& size, RandomSequence* random);
// rows x columns panels with dark gaps and handles.
std::unique_ptr<const Texture> MakePanels(const Eigen::Vector2d& size, int rows, int columns,
                                          const Colour& colour, RandomSequence* random);
// Windows of text on a dark screen.
std::unique_ptr<const Texture> MakeScreen(const Eigen::Vector2d& size, RandomSequence* random);
// Cardboard with a strip of tape and an address label.
std::unique_ptr<const Texture> MakeCardboard(const Eigen::Vector2d& size, RandomSequence* random);

}  // namespace highwall::simulate
