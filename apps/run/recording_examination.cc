#include "run/recording_examination.h"

#include <utility>

#include <highwall/frontend/calibration/lens_pairs.h>
#include <highwall/frontend/input/depth_check.h>
#include <highwall/frontend/input/stamp_check.h>

namespace highwall::apps {

SensorVerdict ExamineRecording(const Dataset& dataset, const RgbdSensor& sensor, std::size_t begin,
                               std::size_t end) {
  SensorVerdict verdict;
  for (SensorFinding& finding : CheckDepth(dataset, sensor, begin, end)) {
    verdict.Add(std::move(finding));
  }
  // Wrong depth contradicts any lens.
  if (verdict.trust() == Trust::kConsistent) {
    if (auto finding = CheckPairs(dataset, sensor, begin, end)) verdict.Add(*std::move(finding));
  }
  SensorFinding stamps{.fault = SensorFault::kStamps, .trust = Trust::kDoubtful};
  for (const StampFinding& finding : CheckStamps(dataset)) {
    stamps.text += (stamps.text.empty() ? "" : "; ") + finding.text;
    stamps.remedy += (stamps.remedy.empty() ? "" : "; ") + finding.remedy;
  }
  if (!stamps.text.empty()) verdict.Add(std::move(stamps));
  return verdict;
}

}  // namespace highwall::apps
