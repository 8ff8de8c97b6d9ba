#include "input/foreign_calibration.h"

#include "fuzz.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "camchain.yaml",
    .seeds =
        [] {
          return std::vector<std::string>{
              "%YAML:1.0\nCamera.type: \"PinHole\"\nCamera.fx: 517.3\nCamera.fy: 516.5\n"
              "Camera.cx: 318.6\nCamera.cy: 255.3\nCamera.k1: 0.26\nCamera.width: 640\n"
              "Camera.height: 480\nDepthMapFactor: 5000.0\nTbc: !!opencv-matrix\n   rows: 4\n"
              "   cols: 4\n   dt: f\n   data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n"
              "IMU.NoiseGyro: 1e-3\nIMU.NoiseAcc: 1e-2\nIMU.GyroWalk: 1e-5\nIMU.AccWalk: 1e-4\n",
              "cam0:\n  T_cam_imu:\n  - [1, 0, 0, 0]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n"
              "  - [0, 0, 0, 1]\n  camera_model: pinhole\n  distortion_coeffs: [0.1, 0, 0, 0]\n"
              "  distortion_model: equidistant\n  intrinsics: [458, 457, 367, 248]\n"
              "  resolution: [752, 480]\n  timeshift_cam_imu: 0.01\n",
              "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n"
              "  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nresolution: [752, 480]\n"
              "camera_model: pinhole\nintrinsics: [458, 457, 367, 248]\n"
              "distortion_model: radial-tangential\ndistortion_coefficients: [0.1, 0, 0, 0]\n",
              "image_width: 640\nimage_height: 480\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
              "  data: [525, 0, 319.5, 0, 525, 239.5, 0, 0, 1]\ndistortion_model: plumb_bob\n"
              "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.1, 0, 0, 0, 0]\n",
              "<?xml version=\"1.0\"?>\n<opencv_storage>\n<image_width>640</image_width>\n"
              "<image_height>480</image_height>\n<!-- K -->\n"
              "<camera_matrix type_id=\"opencv-matrix\">\n  <rows>3</rows>\n  <cols>3</cols>\n"
              "  <dt>d</dt>\n  <data>\n    525. 0. 319.5 0. 525. 239.5 0. 0. 1.</data>"
              "</camera_matrix>\n<fisheye_model>0</fisheye_model>\n<a/></opencv_storage>\n",
              "{\"intrinsic_matrix\":[525,0,0,0,525,0,319,239,1],\"width\":640,\"height\":480}"};
        },
    .file = nullptr,
    .read = [](const std::filesystem::path& path) { ReadForeignCalibration(path); },
};

}  // namespace highwall::fuzz
