#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace highwall {

// Returns the rows of a matrix as "[a, b, c, ...]", with three decimals.
std::string MatrixText(const Eigen::Matrix3d& R);

// Returns the axes of a signed permutation, such as "x, z, -y".
std::string AxesText(const Eigen::Matrix3d& P);

// Returns the 48 matrices that exchange and reverse axes.
std::vector<Eigen::Matrix3d> SignedPermutations();

}  // namespace highwall
