#include "input/scanner_app_frame.h"

#include <vector>

#include <Eigen/Core>

#include <highwall/core/error.h>

#include "input/foreign_map.h"
#include "input/matrix_text.h"
#include "input/phone_recording.h"

namespace highwall {

ScannerAppFrame ReadScannerAppFrame(const std::filesystem::path& path) {
  const ForeignMap json = ForeignMap::LoadJson(path);
  ScannerAppFrame frame;
  frame.stamp = json.Seconds("time");
  frame.camera = CameraOfMatrix(path, json.Numbers("intrinsics", 9));
  const std::vector<double> T = json.Numbers("cameraPoseARFrame", 16);
  try {
    frame.T_WC = FromArkit(
        Pose::FromMatrix(Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(T.data())));
  } catch (const InvalidArgument&) {  // the file's fault, which IoError reports
    throw IoError(path, "'cameraPoseARFrame' is no rotation and translation, row by row");
  }
  return frame;
}

}  // namespace highwall
