#include "run/imu_input.h"

#include <algorithm>
#include <iterator>

#include <highwall/frontend/input/dataset.h>

namespace highwall::apps {

namespace {

// Returns the span of the images in the clock of the IMU.
VideoSpan InClockOf(const ImuCalibration& calibration, const VideoSpan& images) {
  const Stamp offset = FromSeconds(calibration.time_offset);
  return {images.begin + offset, images.end + offset};
}

}  // namespace

SensorFault FaultOf(ImuFindingKind kind) {
  switch (kind) {
    case ImuFindingKind::kOtherClock:
    case ImuFindingKind::kClockRate:
    case ImuFindingKind::kStartsLate:
    case ImuFindingKind::kEndsEarly:
      return SensorFault::kImuClock;
    case ImuFindingKind::kGyroscopeInDegrees:
    case ImuFindingKind::kAccelerometerInG:
    case ImuFindingKind::kAccelerometerImplausible:
    case ImuFindingKind::kGravityRemoved:
      return SensorFault::kImuScale;
    case ImuFindingKind::kColumnsExchanged:
      return SensorFault::kImuAxes;
    case ImuFindingKind::kAccelerometerReversed:
      return SensorFault::kImuSign;
    default:
      return SensorFault::kImuReadings;
  }
}

ImuInput CheckReadings(std::span<const ImuSample> readings, const ImuCalibration& calibration,
                       const VideoSpan& images, double rate) {
  ImuInput input;
  input.calibration = calibration;
  input.findings = CheckImu(readings, InClockOf(calibration, images), {.rate = rate});
  input.samples = RepairImu(readings, input.findings);
  if (input.IsUsable()) {
    std::ranges::copy(DropExceededRanges(input.samples, &input.calibration),
                      std::back_inserter(input.findings));
  }
  return input;
}

std::optional<ImuInput> LoadImu(const Dataset& dataset,
                                const std::optional<ImuCalibration>& calibration) {
  const std::optional<std::filesystem::path> file = dataset.imu_file();
  if (!file || dataset.size() == 0) return std::nullopt;
  const ImuCalibration stated = calibration.value_or(ImuCalibration{});
  const VideoSpan images{dataset.stamp(0), dataset.stamp(dataset.size() - 1)};
  const ImuRecording recording = dataset.ReadImu(InClockOf(stated, images));
  ImuInput input =
      CheckReadings(recording.samples, stated, images, calibration ? calibration->rate : 0.0);
  input.file = *file;

  if (!recording.warning.empty()) input.warnings.push_back(recording.warning);
  for (const ImuFinding& finding : input.findings) {
    const bool has_line = finding.reading && !recording.lines.empty();
    const std::string line =
        has_line ? ":" + std::to_string(recording.lines[*finding.reading]) : "";
    input.warnings.push_back(
        file->string() + line + ": " + finding.text +
        (finding.severity == ImuSeverity::kFatal ? "; the IMU is not used" : ""));
  }
  if (!calibration) {
    input.warnings.push_back(file->string() +
                             ": the IMU is not calibrated: its axes are taken for the camera's; "
                             "put a section 'imu' with T_BC and its noise into calibration.yaml");
  }
  return input;
}

}  // namespace highwall::apps
