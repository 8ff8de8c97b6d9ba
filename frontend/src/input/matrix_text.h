#pragma once

#include <filesystem>
#include <span>

#include <Eigen/Core>

#include <highwall/core/camera.h>

namespace highwall {

// Reads a matrix, row by row, from a text with as many numbers in a line as it has columns,
// separated by blanks or commas; empty lines and lines that begin with # are skipped. nan and inf
// are read as they are. Throws IoError naming the line if a line has another number of them or
// something else, and IoError if the file cannot be read or has another number of rows.
Eigen::MatrixXd ReadMatrixText(const std::filesystem::path& path, int rows, int columns);

// Returns a camera without distortion, of unknown size (0 x 0), from the nine numbers of its matrix
// fx 0 cx, 0 fy cy, 0 0 1, row by row or column by column. Throws IoError naming `path` if they are
// not finite or no such matrix.
PinholeCamera CameraOfMatrix(const std::filesystem::path& path, std::span<const double> matrix);

}  // namespace highwall
