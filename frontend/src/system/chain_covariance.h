#pragma once

#include <span>
#include <vector>

#include <ceres/problem.h>
#include <Eigen/Core>

namespace highwall {

// Returns the covariance of each state of a chain: of its blocks, in the order given and in their
// tangent spaces, all other blocks being estimated as well, from the linearized problem with its
// losses. A residual may depend on the blocks of one state or of two that follow each other, and on
// those in `common`. The problem has no other block that is not constant; none of these is. Empty
// if a direction is not observable or a residual cannot be evaluated. Linear in the number of
// states: a block-tridiagonal system with a border.
std::vector<Eigen::MatrixXd> ChainCovariance(ceres::Problem& problem,
                                             std::span<const std::vector<double*>> states,
                                             std::span<double* const> common);

}  // namespace highwall
