#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/stamp.h>

// The file of SlidingWindowSmoother::Save: docs/sliding_window_smoother.md, "File format".
namespace highwall::internal {

struct SavedVariable {
  bool calibration = false;  // else a state
  Stamp stamp = 0;
  bool fixed = false;
  std::string type;
  std::vector<double> values;
};

struct SavedBlock {
  int variable = 0;           // index into SlidingWindowFile::variables
  std::vector<double> point;  // linearization point
};

struct SlidingWindowFile {
  std::vector<SavedVariable> variables;
  std::vector<SavedBlock> blocks;  // of the prior
  Eigen::MatrixXd A;
  Eigen::VectorXd b;  // empty: no prior
};

// Throws IoError.
void WriteSlidingWindow(const std::filesystem::path& path, const SlidingWindowFile& file);

// Throws IoError, naming the line, if the file is missing, malformed or of another version.
SlidingWindowFile ReadSlidingWindow(const std::filesystem::path& path);

}  // namespace highwall::internal
