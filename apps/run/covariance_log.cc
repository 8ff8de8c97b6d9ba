#include "run/covariance_log.h"

#include <string>

#include <fmt/core.h>

#include <highwall/core/error.h>

namespace highwall::apps {

std::string UpperTriangle(const Eigen::Matrix<double, 6, 6>& covariance) {
  std::string text;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) text += fmt::format(" {:.6g}", covariance(i, j));
  }
  return text;
}

CovarianceLog::CovarianceLog(const std::filesystem::path& path) : path_(path), stream_(path) {
  stream_
      << "# stamp [s] of each frame with a pose, in any world, then the upper triangle of the\n"
         "# covariance of T_WC, row by row: translation [m] and rotation [rad], both along the\n"
         "# axes of the camera\n";
  if (!stream_.flush()) throw IoError(path_, "cannot be written");
}

void CovarianceLog::Append(Stamp stamp, const Eigen::Matrix<double, 6, 6>& covariance) {
  stream_ << FormatStamp(stamp) << UpperTriangle(covariance) << '\n';
  if (!stream_.flush()) throw IoError(path_, "cannot be written");
}

}  // namespace highwall::apps
