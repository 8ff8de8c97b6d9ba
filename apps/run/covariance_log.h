#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include <Eigen/Core>

#include <highwall/core/stamp.h>

namespace highwall::apps {

// Returns the upper triangle of a symmetric matrix, row by row, with a blank before each number.
std::string UpperTriangle(const Eigen::Matrix<double, 6, 6>& covariance);

// A file of the covariances of poses, appended to pose by pose: for each a line of its stamp [s]
// and the upper triangle of the 6 x 6 matrix, row by row. Beside a trajectory, not in it, because
// readers of TUM trajectories refuse further columns.
class CovarianceLog {
 public:
  // Replaces an existing file. Throws IoError.
  explicit CovarianceLog(const std::filesystem::path& path);

  // covariance: as in PoseUncertainty. Throws IoError.
  void Append(Stamp stamp, const Eigen::Matrix<double, 6, 6>& covariance);

 private:
  std::filesystem::path path_;
  std::ofstream stream_;
};

}  // namespace highwall::apps
