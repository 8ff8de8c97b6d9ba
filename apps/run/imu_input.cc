#include "run/imu_input.h"

#include <algorithm>
#include <iterator>

#include <highwall/frontend/input/dataset.h>

namespace highwall::apps {

std::optional<ImuInput> LoadImu(const Dataset& dataset,
                                const std::optional<ImuCalibration>& calibration) {
  const std::optional<std::filesystem::path> file = dataset.imu_file();
  if (!file || dataset.size() == 0) return std::nullopt;
  ImuInput input;
  input.file = *file;
  input.calibration = calibration.value_or(ImuCalibration{});
  const Stamp offset = FromSeconds(input.calibration.time_offset);
  const VideoSpan video{dataset.stamp(0) + offset, dataset.stamp(dataset.size() - 1) + offset};
  const ImuRecording recording = ReadImu(*file, video);
  input.findings = CheckImu(recording.samples, video);
  input.samples = RepairImu(recording.samples, input.findings);
  if (input.IsUsable()) {
    std::ranges::copy(DropExceededRanges(input.samples, &input.calibration),
                      std::back_inserter(input.findings));
  }

  if (!recording.warning.empty()) input.warnings.push_back(recording.warning);
  for (const ImuFinding& finding : input.findings) {
    const std::string line =
        finding.reading ? ":" + std::to_string(recording.lines[*finding.reading]) : "";
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
