#include "sensor/imu_readings.h"

#include <numbers>
#include <utility>

#include "sensor/imu_axes.h"

namespace highwall {

ImuReading ConfiguredReading(const Pose& T_BC) {
  const Eigen::Matrix3d R_CB = T_BC.R().transpose();
  return {.gyroscope = R_CB, .accelerometer = R_CB, .lever_arm = R_CB * T_BC.p()};
}

std::vector<ImuReading> SimpleReadings(const Pose& T_BC) {
  std::vector<ImuReading> all;
  const ImuReading configured = ConfiguredReading(T_BC);
  const auto add = [&](SensorFault fault, double gyroscope, double accelerometer, std::string text,
                       std::string remedy) {
    ImuReading reading = configured;
    reading.gyroscope *= gyroscope;
    reading.accelerometer *= accelerometer;
    reading.fault = fault;
    reading.text = std::move(text);
    reading.remedy = std::move(remedy);
    all.push_back(std::move(reading));
  };
  constexpr double kDegree = std::numbers::pi / 180.0;
  add(SensorFault::kImuScale, kDegree, 1.0,
      "gyroscope and images agree if the readings are in deg/s", "multiply them by 0.0174533");
  add(SensorFault::kImuScale, 1.0 / kDegree, 1.0,
      "gyroscope and images agree if the readings were multiplied by pi / 180 once too often",
      "multiply them by 57.2958");
  for (const auto& [factor, text] : {std::pair{0.5, "half"}, std::pair{2.0, "twice"}}) {
    add(SensorFault::kImuScale, factor, 1.0,
        std::string("gyroscope and images agree if the gyroscope turns ") + text +
            " as fast as it reads: it is set to another range than its driver assumes",
        std::string("multiply its readings by ") + (factor < 1.0 ? "0.5" : "2"));
  }
  add(SensorFault::kImuSign, -1.0, 1.0,
      "gyroscope and images agree if the sign of the gyroscope is reversed", "multiply it by -1");
  add(SensorFault::kImuSign, 1.0, -1.0,
      "accelerometer and images agree if the sign of the accelerometer is reversed (at rest it "
      "must point up)",
      "multiply it by -1");
  add(SensorFault::kImuSign, -1.0, -1.0,
      "IMU and images agree if the signs of all readings are reversed", "multiply them by -1");
  add(SensorFault::kImuMount, 1.0, 1.0,
      "IMU and images agree if T_BC is inverted: it is likely given as T_CB",
      "invert T_BC in calibration.yaml");
  all.back().gyroscope = all.back().accelerometer = configured.gyroscope.transpose();
  all.back().lever_arm = -T_BC.p();
  for (const auto& [scale, unit] : {std::pair{0.01, "cm"}, std::pair{0.001, "mm"}}) {
    add(SensorFault::kImuLeverArm, 1.0, 1.0,
        std::string("accelerometer and images agree if the translation of T_BC is in ") + unit,
        "give it in m");
    all.back().lever_arm *= scale;
  }
  return all;
}

// A T_BC that is wrong in rotation leaves open which lever arm was meant.
ImuReading TurnedReading(const Pose& T_BC, const Eigen::Matrix3d& R_CB) {
  ImuReading turned = ConfiguredReading(T_BC);
  turned.gyroscope = turned.accelerometer = R_CB;
  turned.lever_sigma = 0.3;
  turned.fault = SensorFault::kImuMount;
  turned.text = "IMU and images agree if the rotation of T_BC is about " +
                MatrixText(turned.gyroscope.transpose());
  turned.remedy = "correct T_BC in calibration.yaml";
  return turned;
}

}  // namespace highwall
