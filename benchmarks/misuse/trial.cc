#include "trial.h"

#include <algorithm>
#include <exception>

#include <highwall/core/error.h>
#include <highwall/core/trajectory_error.h>
#include <highwall/frontend/input/imu_check.h>

#include "run/imu_input.h"
#include "run/recording_examination.h"
#include "run/slam_run.h"

namespace highwall::bench {
namespace {

// Checks the IMU as LoadImu() does, and uses it if it can be used.
void TakeImu(const StatedSequence& sequence, apps::SlamRunOptions* options) {
  const std::optional<apps::ImuFeed>& imu = sequence.stated().imu;
  if (!imu) return;
  const VideoSpan images{sequence.stamp(0), sequence.stamp(sequence.size() - 1)};
  apps::ImuInput input =
      apps::CheckReadings(imu->samples, imu->calibration, images, imu->calibration.rate);
  for (const ImuFinding& finding : input.findings) {
    options->before.Add(
        {apps::FaultOf(finding.kind),
         finding.severity == ImuSeverity::kFatal ? Trust::kNotTrusted : Trust::kDoubtful,
         finding.text});
  }
  if (input.IsUsable()) options->imu = apps::ImuFeed{input.calibration, std::move(input.samples)};
}

// What the command says of the IMU after the run, beside its findings.
void TellOfImu(const apps::SlamRun& run, SensorVerdict* verdict) {
  if (!run.inertial || run.inertial->given_up == 0) return;
  const bool reversed = run.inertial->given_up_because == AccelerometerReversed().text;
  verdict->Add({reversed ? SensorFault::kImuSign : SensorFault::kImuInconsistent, Trust::kDoubtful,
                run.inertial->given_up_because});
}

void Score(const StatedSequence& sequence, const apps::SlamRun& run, Trial* trial) {
  const Trajectory estimate = sequence.AtTrueStamps(run.largest.trajectory);
  const auto frames = static_cast<double>(sequence.size());
  trial->posed = static_cast<double>(estimate.size()) / frames;
  trial->keyframes = static_cast<double>(run.keyframes_made) / frames;
  trial->processor_ms = apps::ProcessorMsPerFrame(run);
  try {
    trial->ape = AbsolutePoseError(*sequence.groundtruth(), estimate).statistics.rmse;
  } catch (const InvalidArgument&) {  // too few poses
  }
}

}  // namespace

Trial RunStated(const StatedSequence& sequence) {
  apps::SlamRunOptions options;
  options.slam = Deterministic(options.slam);
  options.dense = false;
  options.prefetch = 0;
  Trial trial;
  try {
    options.before = apps::ExamineRecording(sequence, sequence.stated().sensor);
    TakeImu(sequence, &options);
    trial.verdict = options.before;
    const apps::SlamRun run = apps::RunSlam(sequence, sequence.stated().sensor, options);
    trial.verdict = run.verdict;
    if (run.largest.trajectory.empty()) trial.refusal = "no frame could be tracked";
    TellOfImu(run, &trial.verdict);
    Score(sequence, run, &trial);
  } catch (const std::exception& error) {  // as the command does, which prints it
    trial.refusal = error.what();
  }
  return trial;
}

StatedSequence Misstate(const TrueRecording& recording, const Misuse& misuse) {
  StatedRecording stated = TruthOf(recording);
  if (!misuse.inertial) stated.imu.reset();
  misuse.apply(&stated);
  return StatedSequence(recording, std::move(stated));
}

bool IsDetected(const Trial& trial) {
  return !trial.refusal.empty() || !trial.verdict.findings.empty();
}

bool IsNamed(const Trial& trial, const std::vector<SensorFault>& expected) {
  const auto has = [&](SensorFault fault) {
    return std::ranges::find(expected, fault) != expected.end();
  };
  if (!trial.refusal.empty() && has(SensorFault::kStamps)) return true;
  return std::ranges::any_of(trial.verdict.findings, has, &SensorFinding::fault);
}

}  // namespace highwall::bench
