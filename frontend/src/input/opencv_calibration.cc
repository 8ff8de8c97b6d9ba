#include "input/opencv_calibration.h"

#include <initializer_list>
#include <string>
#include <vector>

#include "input/foreign_camera.h"

namespace highwall {
namespace {

// Returns the spelling of a key that the file has; the first if it has none.
std::string SpellingOf(const ForeignMap& file, std::initializer_list<const char*> spellings) {
  for (const char* const key : spellings) {
    if (file.Has(key)) return key;
  }
  return *spellings.begin();
}

std::vector<double> CoefficientsOf(const ForeignMap& file, const std::string& key) {
  return file.Has(key) ? file.Matrix(key, 0) : std::vector<double>();
}

}  // namespace

SensorCalibration ReadOpencvCalibration(const ForeignMap& file) {
  SensorCalibration calibration = StartForeignCalibration("a camera calibration of OpenCV");
  const std::string matrix = SpellingOf(file, {"camera_matrix", "Camera_Matrix", "cameraMatrix"});
  const std::string lens = SpellingOf(
      file, {"distortion_coefficients", "Distortion_Coefficients", "distCoeffs", "dist_coeffs"});
  PinholeCamera& camera = calibration.sensor.camera;
  camera = ForeignMatrixCamera(file, matrix, file.Matrix(matrix, 9),
                               SpellingOf(file, {"image_width", "image_Width"}),
                               SpellingOf(file, {"image_height", "image_Height"}));
  const bool is_fisheye = file.Has("fisheye_model") && file.Number("fisheye_model") != 0.0;
  SetForeignLens(file, "fisheye_model", is_fisheye ? "equidistant" : "", lens,
                 CoefficientsOf(file, lens), &camera);
  return calibration;
}

SensorCalibration ReadCameraInfoFile(const ForeignMap& file) {
  SensorCalibration calibration = StartForeignCalibration("a camera_info of ROS");
  const std::string matrix = SpellingOf(file, {"camera_matrix", "K", "k"});
  const std::string lens = SpellingOf(file, {"distortion_coefficients", "D", "d"});
  PinholeCamera& camera = calibration.sensor.camera;
  camera = ForeignMatrixCamera(file, matrix, file.Matrix(matrix, 9),
                               SpellingOf(file, {"image_width", "width"}),
                               SpellingOf(file, {"image_height", "height"}));
  const std::string model =
      file.Has("distortion_model") ? file.Word("distortion_model") : std::string();
  SetForeignLens(file, "distortion_model", model, lens, CoefficientsOf(file, lens), &camera);
  return calibration;
}

}  // namespace highwall
