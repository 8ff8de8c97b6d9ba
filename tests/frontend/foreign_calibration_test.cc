// ReadSensor() of calibrations that other systems write.
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/frontend/input/sensor.h>

#include "support/message_of.h"
#include "support/temporary_directory.h"

namespace highwall::foreign_calibration_test {
namespace {

using testing::ExpectError;
using testing::WriteText;

using Names = std::vector<std::string>;

class ForeignCalibration : public ::testing::Test {
 protected:
  SensorCalibration Read(const std::string& text, const std::string& name = "calibration") const {
    WriteText(folder_ / name, text);
    return ReadSensor(folder_ / name);
  }
  // message: after the path.
  void ExpectRefused(const std::string& text, const std::string& message) const {
    ExpectError<IoError>((folder_ / "calibration").string() + message, [&] { Read(text); });
  }
  const testing::TemporaryDirectory folder_;
};

void ExpectCamera(const PinholeCamera& camera, const PinholeCamera& expected) {
  EXPECT_EQ(camera.width, expected.width);
  EXPECT_EQ(camera.height, expected.height);
  for (const auto field :
       {&PinholeCamera::fx, &PinholeCamera::fy, &PinholeCamera::cx, &PinholeCamera::cy,
        &PinholeCamera::k1, &PinholeCamera::k2, &PinholeCamera::p1, &PinholeCamera::p2,
        &PinholeCamera::k3, &PinholeCamera::k4, &PinholeCamera::k5, &PinholeCamera::k6}) {
    EXPECT_EQ(camera.*field, expected.*field);
  }
  EXPECT_EQ(camera.lens, expected.lens);
}

PinholeCamera Camera() {
  return {.width = 640, .height = 480, .fx = 517.5, .fy = 516.5, .cx = 318.5, .cy = 255.25};
}

PinholeCamera Lens(double k1, double k2, double p1, double p2, double k3 = 0.0) {
  PinholeCamera camera = Camera();
  camera.k1 = k1;
  camera.k2 = k2;
  camera.p1 = p1;
  camera.p2 = p2;
  camera.k3 = k3;
  return camera;
}

PinholeCamera Fisheye(double k1, double k2, double k3, double k4) {
  PinholeCamera camera = Lens(k1, k2, 0.0, 0.0, k3);
  camera.k4 = k4;
  camera.lens = LensModel::kEquidistant;
  return camera;
}

const std::string kOrbSlam2 =
    "%YAML:1.0\n\n# camera: of TUM1\nCamera.fx: 517.5\nCamera.fy: 516.5\nCamera.cx: 318.5\n"
    "Camera.cy: 255.25\n\nCamera.k1: 0.25\nCamera.k2: -0.5\nCamera.p1: -0.125\n"
    "Camera.p2: 0.0625\nCamera.k3: 1.5\n\nCamera.width: 640\nCamera.height: 480\n"
    "Camera.fps: 30.0\nCamera.bf: 40.0\nCamera.RGB: 1\nThDepth: 40.0\n";

TEST_F(ForeignCalibration, ReadsTheSettingsOfOrbSlam2) {
  const SensorCalibration read = Read(kOrbSlam2 + "DepthMapFactor: 5000.0\n");
  EXPECT_EQ(read.format, "a settings file of ORB-SLAM");
  ExpectCamera(read.sensor.camera, Lens(0.25, -0.5, -0.125, 0.0625, 1.5));
  EXPECT_EQ(read.sensor.depth_factor, 5000.0);
  EXPECT_EQ(read.defaults, Names({"depth_range", "depth_noise"}));
  EXPECT_FALSE(read.imu);
  const SensorCalibration monocular = Read(kOrbSlam2);
  EXPECT_EQ(monocular.sensor.depth_factor, 1000.0);
  EXPECT_EQ(monocular.defaults, Names({"depth_factor", "depth_range", "depth_noise"}));
}

TEST_F(ForeignCalibration, ReadsTheSettingsOfOrbSlam3WithAFisheyeAndAnImu) {
  const SensorCalibration read = Read(
      "%YAML:1.0\n\nFile.version: \"1.0\"\nCamera.type: \"KannalaBrandt8\"\nCamera1.fx: 517.5\n"
      "Camera1.fy: 516.5\nCamera1.cx: 318.5\nCamera1.cy: 255.25\nCamera1.k1: 0.25\n"
      "Camera1.k2: -0.5\nCamera1.k3: 0.125\nCamera1.k4: -0.0625\nCamera.width: 640\n"
      "Camera.height: 480\nRGBD.DepthMapFactor: 4000.0\nIMU.T_b_c1: !!opencv-matrix\n   rows: 4\n"
      "   cols: 4\n   dt: f\n   data: [0.0, 0.0, 1.0, 0.5,\n         -1.0, 0.0, 0.0, 0.25,\n"
      "         0.0, -1.0, 0.0, 0.125,\n         0.0, 0.0, 0.0, 1.0]\nIMU.NoiseGyro: 1e-3\n"
      "IMU.NoiseAcc: 2e-2 # m/s^1.5\nIMU.GyroWalk: 3e-5\nIMU.AccWalk: 4e-4\nIMU.Frequency: "
      "250.0\n");
  ExpectCamera(read.sensor.camera, Fisheye(0.25, -0.5, 0.125, -0.0625));
  EXPECT_EQ(read.sensor.depth_factor, 4000.0);
  ASSERT_TRUE(read.imu);
  // T_b_c1 maps from the camera to the body: its axis z is x of the body.
  EXPECT_EQ(read.imu->T_BC * Eigen::Vector3d::Zero(), Eigen::Vector3d(0.5, 0.25, 0.125));
  EXPECT_LT((read.imu->T_BC * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(1.5, 0.25, 0.125)).norm(),
            1e-15);
  EXPECT_EQ(read.imu->noise.gyroscope, 1e-3);
  EXPECT_EQ(read.imu->noise.accelerometer, 2e-2);
  EXPECT_EQ(read.imu->noise.gyroscope_walk, 3e-5);
  EXPECT_EQ(read.imu->noise.accelerometer_walk, 4e-4);
  EXPECT_EQ(read.imu->rate, 250.0);
  EXPECT_EQ(read.defaults, Names({"depth_range", "depth_noise", "imu: time_offset"}));
}

TEST_F(ForeignCalibration, NamesTheFaultOfOrbSlamsSettings) {
  ExpectRefused("%YAML:1.0\nCamera.fx: 517\n",
                ":2: Camera.width and Camera.height are missing: add the size of the images, such "
                "as 'Camera.width: 640' and 'Camera.height: 480'");
  ExpectRefused(kOrbSlam2 + "Camera.type: \"Omni\"\n",
                ":21: 'Camera.type' must be PinHole, Rectified or KannalaBrandt8, found 'Omni'");
  ExpectRefused(kOrbSlam2 + "DepthMapFactor: 0\n", ":21: 'DepthMapFactor' must be positive");
  ExpectRefused(kOrbSlam2 + "\nTbc: !!opencv-matrix\n  rows: 4\n  cols: 4\n  data: [1, 2]\n",
                ":22: 'Tbc' must be a matrix whose data is a list of 16 finite numbers");
  ExpectRefused(kOrbSlam2 + "Camera.fps: [1\n}\n", ":22: is not YAML: ");
  ExpectRefused(
      "%YAML:1.0\nCamera.fx: 0.8\nCamera.fy: 0.8\nCamera.cx: 0.5\nCamera.cy: 0.5\n"
      "Camera.width: 640\nCamera.height: 480\n",
      ":2: fx is 0.8 px, less than a tenth of the image's width (640)");
}

const std::string kMatrix = "data: [517.5, 0., 318.5, 0., 516.5, 255.25, 0., 0., 1.]";

// coefficients: of a matrix of OpenCV.
std::string OpencvYaml(const std::string& coefficients, const std::string& more = "") {
  return "%YAML:1.0\n---\ncalibration_time: \"Sat 28 Nov 2026\"\nimage_width: 640\n"
         "image_height: 480\n" +
         more + "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   " + kMatrix +
         "\ndistortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: "
         "[" +
         coefficients + "]\navg_reprojection_error: 2.5e-01\n";
}

TEST_F(ForeignCalibration, ReadsTheResultOfOpencvInYaml) {
  const SensorCalibration read = Read(OpencvYaml("0.25, -0.5,\n       -0.125, 0.0625, 1.5"));
  EXPECT_EQ(read.format, "a camera calibration of OpenCV");
  ExpectCamera(read.sensor.camera, Lens(0.25, -0.5, -0.125, 0.0625, 1.5));
  EXPECT_EQ(read.defaults, Names({"depth_factor", "depth_range", "depth_noise"}));
  ExpectCamera(Read(OpencvYaml("0.25, -0.5, -0.125, 0.0625")).sensor.camera,
               Lens(0.25, -0.5, -0.125, 0.0625));
  PinholeCamera rational = Lens(0.25, -0.5, -0.125, 0.0625, 1.5);
  rational.k4 = 2.0;
  rational.k5 = 3.0;
  rational.k6 = 4.0;
  ExpectCamera(
      Read(OpencvYaml("0.25, -0.5, -0.125, 0.0625, 1.5, 2., 3., 4., 0., 0., 0., 0.")).sensor.camera,
      rational);
  ExpectCamera(Read(OpencvYaml("0.25, -0.5, 0.125, -0.0625", "fisheye_model: 1\n")).sensor.camera,
               Fisheye(0.25, -0.5, 0.125, -0.0625));
}

TEST_F(ForeignCalibration, ReadsTheResultOfOpencvInXml) {
  const SensorCalibration read = Read(
      "<?xml version=\"1.0\"?>\n<opencv_storage>\n<!-- of 2026 -->\n"
      "<calibration_Time>\"Sat 28 Nov 2026\"</calibration_Time>\n<image_Width>640</image_Width>\n"
      "<image_Height>480</image_Height>\n<Camera_Matrix type_id=\"opencv-matrix\">\n"
      "  <rows>3</rows>\n  <cols>3</cols>\n  <dt>d</dt>\n  <data>\n"
      "    517.5 0. 318.5 0. 516.5\n    255.25 0. 0. 1.</data></Camera_Matrix>\n"
      "<Distortion_Coefficients type_id=\"opencv-matrix\">\n  <rows>5</rows>\n  <cols>1</cols>\n"
      "  <dt>d</dt>\n  <data>\n    2.5e-01 -5.e-01 -.125 0.0625\n    1.5</data>"
      "</Distortion_Coefficients>\n<empty/>\n</opencv_storage>\n");
  ExpectCamera(read.sensor.camera, Lens(0.25, -0.5, -0.125, 0.0625, 1.5));
}

TEST_F(ForeignCalibration, NamesTheFaultOfOpencvsResult) {
  ExpectRefused(OpencvYaml("0.25, -0.5, -0.125, 0.0625, 1.5, 2., 3., 4., 0.5"),
                ":11: 'distortion_coefficients' has coefficients of a thin prism or a tilted "
                "sensor, which are not known: calibrate with k1 to k6");
  ExpectRefused(OpencvYaml("0.25, -0.5, 0.125, -0.0625, 0.5", "fisheye_model: 1\n"),
                ":12: 'distortion_coefficients' must be the 4 coefficients of an equidistant lens");
  ExpectRefused("<?xml version=\"1.0\"?>\n<opencv_storage>\n<camera_matrix>1 2\n</b>",
                ":4: is not XML of OpenCV: expected </camera_matrix>");
  ExpectRefused("%YAML:1.0\n---\nM1: !!opencv-matrix\n   rows: 3\n",
                ": is a file of OpenCV's FileStorage without image_width, image_height and "
                "camera_matrix, which is not read; write 'camera: {width: 640, height: 480");
}

std::string CameraInfo(const std::string& model, const std::string& coefficients) {
  return "image_width: 640\nimage_height: 480\ncamera_name: rgb\ncamera_matrix:\n  rows: 3\n"
         "  cols: 3\n  " +
         kMatrix + "\ndistortion_model: " + model +
         "\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [" + coefficients +
         "]\nrectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
         "projection_matrix:\n  rows: 3\n  cols: 4\n"
         "  data: [500, 0, 300, 0, 0, 500, 200, 0, 0, 0, 1, 0]\n";
}

TEST_F(ForeignCalibration, ReadsACameraInfoOfRos) {
  const SensorCalibration read = Read(CameraInfo("plumb_bob", "0.25, -0.5, -0.125, 0.0625, 1.5"));
  EXPECT_EQ(read.format, "a camera_info of ROS");
  ExpectCamera(read.sensor.camera, Lens(0.25, -0.5, -0.125, 0.0625, 1.5));
  PinholeCamera rational = Lens(0.25, -0.5, -0.125, 0.0625, 1.5);
  rational.k4 = 2.0;
  rational.k5 = 3.0;
  rational.k6 = 4.0;
  ExpectCamera(Read(CameraInfo("rational_polynomial", "0.25, -0.5, -0.125, 0.0625, 1.5, 2, 3, 4"))
                   .sensor.camera,
               rational);
  ExpectCamera(Read(CameraInfo("equidistant", "0.25, -0.5, 0.125, -0.0625")).sensor.camera,
               Fisheye(0.25, -0.5, 0.125, -0.0625));
  // A message, as rostopic echo and ros2 topic echo print it.
  for (const bool lower : {false, true}) {
    const SensorCalibration message = Read(
        "header:\n  frame_id: \"rgb\"\nheight: 480\nwidth: 640\ndistortion_model: \"plumb_bob\"\n" +
        std::string(lower ? "d" : "D") + ": [0.25, -0.5, -0.125, 0.0625, 1.5]\n" +
        (lower ? "k" : "K") + ": [517.5, 0.0, 318.5, 0.0, 516.5, 255.25, 0.0, 0.0, 1.0]\n---\n");
    ExpectCamera(message.sensor.camera, Lens(0.25, -0.5, -0.125, 0.0625, 1.5));
  }
}

TEST_F(ForeignCalibration, NamesTheFaultOfACameraInfo) {
  ExpectRefused(CameraInfo("thin_prism", "0.1, 0, 0, 0"),
                ":8: the lens model 'thin_prism' is not known: calibrate with a radial-tangential "
                "model (radtan, plumb_bob) or, for a fisheye, an equidistant one");
  ExpectRefused(
      "image_width: 640\nimage_height: 480\n"
      "camera_matrix: {rows: 3, cols: 3, data: [0, 0, 0, 0, 0, 0, 0, 0, 0]}\n",
      ":3: the camera matrix must be fx 0 cx, 0 fy cy, 0 0 1");
  ExpectRefused(
      "image_height: 480\ncamera_matrix: {" + kMatrix + "}\ndistortion_model: plumb_bob\n",
      ": has no 'image_width'");
}

const std::string kKalibrCamera =
    "  camera_model: pinhole\n  distortion_coeffs: [0.25, -0.5, -0.125, 0.0625]\n"
    "  distortion_model: radtan\n  intrinsics: [517.5, 516.5, 318.5, 255.25]\n"
    "  resolution: [640, 480]\n  rostopic: /cam0/image_raw\n";
const std::string kKalibrImu =
    "  T_cam_imu:\n  - [0.0, -1.0, 0.0, 0.5]\n  - [0.0, 0.0, -1.0, 0.25]\n"
    "  - [1.0, 0.0, 0.0, 0.125]\n  - [0.0, 0.0, 0.0, 1.0]\n  timeshift_cam_imu: 0.0125\n";
const std::string kImuYaml =
    "accelerometer_noise_density: 2e-2\naccelerometer_random_walk: 4e-4\n"
    "gyroscope_noise_density: 1e-3\ngyroscope_random_walk: 3e-5\nrostopic: /imu0\n"
    "update_rate: 250.0\n";

void ExpectKalibrImu(const ImuCalibration& imu) {
  EXPECT_EQ(imu.noise.gyroscope, 1e-3);
  EXPECT_EQ(imu.noise.accelerometer, 2e-2);
  EXPECT_EQ(imu.noise.gyroscope_walk, 3e-5);
  EXPECT_EQ(imu.noise.accelerometer_walk, 4e-4);
  EXPECT_EQ(imu.rate, 250.0);
}

TEST_F(ForeignCalibration, ReadsTheFirstCameraOfAChainOfKalibr) {
  const SensorCalibration read = Read("cam0:\n" + kKalibrCamera);
  EXPECT_EQ(read.format, "a camera chain of Kalibr");
  ExpectCamera(read.sensor.camera, Lens(0.25, -0.5, -0.125, 0.0625));
  EXPECT_FALSE(read.imu);
  EXPECT_EQ(Read("cam0:\n" + kKalibrCamera + "cam1:\n  camera_model: omni\n").format,
            "a camera chain of Kalibr, of which cam0 is used");
  ExpectCamera(Read("cam0:\n  camera_model: pinhole\n  distortion_coeffs: [0.25, -0.5, 0.125, "
                    "-0.0625]\n  distortion_model: equidistant\n  intrinsics: [517.5, 516.5, "
                    "318.5, 255.25]\n  resolution: [640, 480]\n")
                   .sensor.camera,
               Fisheye(0.25, -0.5, 0.125, -0.0625));
}

TEST_F(ForeignCalibration, TurnsTheTransformOfKalibrIntoThePoseOfTheCamera) {
  const SensorCalibration read = Read("cam0:\n" + kKalibrImu + kKalibrCamera);
  ASSERT_TRUE(read.imu);
  // T_cam_imu takes the origin of the IMU to (0.5, 0.25, 0.125) of the camera, and T_BC back.
  EXPECT_LT((read.imu->T_BC * Eigen::Vector3d(0.5, 0.25, 0.125)).norm(), 1e-15);
  // The axis of the camera is x of the IMU.
  EXPECT_LT((read.imu->T_BC.R() * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(1, 0, 0)).norm(),
            1e-15);
  EXPECT_EQ(read.imu->time_offset, 0.0125);  // t_imu = t_cam + shift
  EXPECT_EQ(read.imu->noise.gyroscope, ImuNoise{}.gyroscope);
  EXPECT_EQ(read.defaults,
            Names({"depth_factor", "depth_range", "depth_noise", "imu: noise", "imu: rate"}));
}

TEST_F(ForeignCalibration, ReadsTheImuOfKalibrBesideTheChain) {
  const std::string chain = "cam0:\n" + kKalibrImu + kKalibrCamera;
  WriteText(folder_ / "imu.yaml", kImuYaml);
  const SensorCalibration read = Read(chain, "camchain.yaml");
  EXPECT_EQ(read.format, "a camera chain of Kalibr with imu.yaml");
  EXPECT_EQ(read.defaults, Names({"depth_factor", "depth_range", "depth_noise"}));
  ExpectKalibrImu(read.imu.value());
  // The names and the form of its results.
  std::string result = "imu0:\n  T_i_b:\n  - [1.0, 0.0, 0.0, 0.0]\n  model: calibrated\n";
  for (std::size_t at = 0, end = 0; at < kImuYaml.size(); at = end) {
    end = kImuYaml.find('\n', at) + 1;
    result += "  " + kImuYaml.substr(at, end - at);
  }
  WriteText(folder_ / "imu.yaml", "gyroscope_noise_density: x\n");
  WriteText(folder_ / "walk-imu.yaml", result);
  WriteText(folder_ / "imu-walk.yaml", result);
  for (const char* const name : {"walk-camchain-imucam.yaml", "camchain-imucam-walk.yaml"}) {
    ExpectKalibrImu(Read(chain, name).imu.value());
  }
  ExpectError<IoError>("imu.yaml:1: 'gyroscope_noise_density' must be a finite number",
                       [&] { Read(chain, "camchain.yaml"); });
}

TEST_F(ForeignCalibration, NamesTheFaultOfAChainOfKalibr) {
  for (const char* const model : {"omni", "eucm", "ds"}) {
    ExpectRefused("cam0:\n  intrinsics: [1, 2, 3, 4, 5]\n  camera_model: " + std::string(model),
                  ":3: the camera model '" + std::string(model) +
                      "' is not known: calibrate with pinhole-radtan or, for a fisheye, "
                      "pinhole-equi, or undistort the images");
  }
  ExpectRefused(
      "cam0:\n  camera_model: pinhole\n  distortion_model: fov\n  distortion_coeffs: "
      "[0.9]\n  intrinsics: [517.5, 516.5, 318.5, 255.25]\n  resolution: [640, 480]\n",
      ":3: the lens model 'fov' is not known");
  ExpectRefused("\ncam0:\n  camera_model: pinhole\n  intrinsics: [517.5, 516.5, 318.5, 255.25]\n",
                ":2: 'cam0' has no 'resolution'");
  ExpectRefused("cam0:\n  T_cam_imu:\n  - [1, 0, 0, 0]\n" + kKalibrCamera,
                ":2: 'T_cam_imu' must be the 16 numbers of a rotation and a translation");
  ExpectRefused("cam0:\n" + kKalibrCamera +
                    "  timeshift_cam_imu: 30\n  T_cam_imu:\n  - [1, 0, 0, 0]\n  - [0, 1, 0, 0]\n"
                    "  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\n",
                ":8: time_offset must be in [-1, 1] s, got 30");
}

// The camera looks along x of the body, at (0.5, 0.25, 0.125).
const std::string kEurocCamera =
    "# General sensor definitions.\nsensor_type: camera\ncomment: VI-Sensor cam0 (MT9M034)\n\n"
    "T_BS:\n  cols: 4\n  rows: 4\n  data: [0.0, 0.0, 1.0, 0.5,\n         -1.0, 0.0, 0.0, 0.25,\n"
    "         0.0, -1.0, 0.0, 0.125,\n         0.0, 0.0, 0.0, 1.0]\n\nrate_hz: 20\n"
    "resolution: [640, 480]\ncamera_model: pinhole\n"
    "intrinsics: [517.5, 516.5, 318.5, 255.25] #fu, fv, cu, cv\n";
const std::string kEurocLens =
    "distortion_model: radial-tangential\n"
    "distortion_coefficients: [0.25, -0.5, -0.125, 0.0625]\n";
// Half a turn about z from the body, and 1 m above it.
const std::string kEurocImu =
    "sensor_type: imu\nT_BS:\n  cols: 4\n  rows: 4\n  data: [-1.0, 0.0, 0.0, 0.0,\n"
    "         0.0, -1.0, 0.0, 0.0,\n         0.0, 0.0, 1.0, 1.0,\n         0.0, 0.0, 0.0, 1.0]\n"
    "rate_hz: 250\ngyroscope_noise_density: 1e-3     # [ rad / s / sqrt(Hz) ]\n"
    "gyroscope_random_walk: 3e-5\naccelerometer_noise_density: 2e-2\n"
    "accelerometer_random_walk: 4e-4\n";

TEST_F(ForeignCalibration, ReadsTheSensorFileOfEuroc) {
  const SensorCalibration read = Read(kEurocCamera + kEurocLens);
  EXPECT_EQ(read.format, "a sensor.yaml of EuRoC");
  ExpectCamera(read.sensor.camera, Lens(0.25, -0.5, -0.125, 0.0625));
  EXPECT_EQ(read.defaults, Names({"depth_factor", "depth_range", "depth_noise", "imu: noise",
                                  "imu: rate", "imu: time_offset"}));
  ASSERT_TRUE(read.imu);
  EXPECT_EQ(read.imu->T_BC.p(), Eigen::Vector3d(0.5, 0.25, 0.125));
  EXPECT_LT((read.imu->T_BC.R() * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(1, 0, 0)).norm(),
            1e-15);
  ExpectCamera(Read(kEurocCamera + "distortion_model: equidistant\n"
                                   "distortion_coefficients: [0.25, -0.5, 0.125, -0.0625]\n")
                   .sensor.camera,
               Fisheye(0.25, -0.5, 0.125, -0.0625));
  const std::size_t pose = kEurocCamera.find("T_BS"), rate = kEurocCamera.find("rate_hz");
  EXPECT_FALSE(Read(kEurocCamera.substr(0, pose) + kEurocCamera.substr(rate) + kEurocLens).imu);
}

TEST_F(ForeignCalibration, ReadsTheImuOfEurocBesideTheCamera) {
  for (const char* const sensor : {"cam0", "imu0"}) {
    std::filesystem::create_directory(folder_ / sensor);
  }
  WriteText(folder_ / "imu0/sensor.yaml", kEurocImu);
  const SensorCalibration read = Read(kEurocCamera + kEurocLens, "cam0/sensor.yaml");
  EXPECT_EQ(read.format, "a sensor.yaml of EuRoC with imu0/sensor.yaml");
  EXPECT_EQ(read.defaults,
            Names({"depth_factor", "depth_range", "depth_noise", "imu: time_offset"}));
  ExpectKalibrImu(read.imu.value());  // the same numbers
  // The camera in the frame of the IMU, not in that of the body.
  EXPECT_LT((read.imu->T_BC.p() - Eigen::Vector3d(-0.5, -0.25, -0.875)).norm(), 1e-15);
  EXPECT_LT((read.imu->T_BC.R() * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(-1, 0, 0)).norm(),
            1e-15);
  WriteText(folder_ / "imu0/sensor.yaml", kEurocImu + "rate_hz: x\n");
  ExpectError<IoError>(
      (folder_ / "imu0/sensor.yaml").string() + ":14: 'rate_hz' must be a finite number",
      [&] { Read(kEurocCamera + kEurocLens, "cam0/sensor.yaml"); });
}

TEST_F(ForeignCalibration, NamesTheFaultOfASensorFileOfEuroc) {
  ExpectRefused("sensor_type: camera\nintrinsics: [1, 2, 3, 4, 5]\ncamera_model: omni\n",
                ":3: the camera model 'omni' is not known: calibrate a pinhole camera with a "
                "radial-tangential or, for a fisheye, an equidistant lens");
  ExpectRefused(kEurocCamera + "distortion_model: fov\ndistortion_coefficients: [1, 0, 0, 0]\n",
                ":17: the lens model 'fov' is not known");
  ExpectRefused(kEurocCamera + "distortion_model: radial-tangential\n",
                ": has no 'distortion_coefficients'");
  ExpectRefused(kEurocCamera + kEurocLens + "T_BS: [1, 2]\n",
                ":19: 'T_BS' must be a list of 16 finite numbers");
}

TEST_F(ForeignCalibration, ReadsAnIntrinsicOfOpen3d) {
  const std::string camera =
      "{\n\t\"width\" : 640,\n\t\"height\" : 480,\n\t\"intrinsic_matrix\" :\n\t[\n\t\t517.5,\n"
      "\t\t0,\n\t\t0,\n\t\t0,\n\t\t516.5,\n\t\t0,\n\t\t318.5,\n\t\t255.25,\n\t\t1\n\t]";
  const SensorCalibration read = Read(camera + "\n}\n");
  EXPECT_EQ(read.format, "a camera intrinsic of Open3D");
  ExpectCamera(read.sensor.camera, Camera());
  EXPECT_EQ(read.defaults, Names({"depth_factor", "depth_range", "depth_noise"}));
  const SensorCalibration scaled = Read(camera + ",\n\t\"depth_scale\" : 4000\n}\n");
  EXPECT_EQ(scaled.sensor.depth_factor, 4000.0);
  EXPECT_EQ(scaled.defaults, Names({"depth_range", "depth_noise"}));
  ExpectRefused("{\"width\": 640, \"height\": 480,\n\"intrinsic_matrix\": [1, 2]}",
                ":2: 'intrinsic_matrix' must be a list of 9 finite numbers");
}

TEST_F(ForeignCalibration, ACalibrationOfHighwallHasNoFormatAndNoDefaults) {
  const SensorCalibration read = Read(
      "# once Camera.fx: and cam0: of others\n"
      "camera: {width: 640, height: 480, fx: 525, fy: 525, cx: 319, cy: 239}\n"
      "depth_factor: 5000\n");
  EXPECT_EQ(read.format, "");
  EXPECT_TRUE(read.defaults.empty());
}

}  // namespace
}  // namespace highwall::foreign_calibration_test
