#include "run/recording_examination.h"

#include <utility>

#include <highwall/frontend/input/depth_check.h>
#include <highwall/frontend/input/stamp_check.h>

namespace highwall::apps {

SensorVerdict ExamineRecording(const Dataset& dataset, const RgbdSensor& sensor, std::size_t begin,
                               std::size_t end) {
  SensorVerdict verdict;
  for (SensorFinding& finding : CheckDepth(dataset, sensor, begin, end)) {
    verdict.Add(std::move(finding));
  }
  for (const StampFinding& finding : CheckStamps(dataset)) {
    verdict.Add({SensorFault::kStamps, Trust::kDoubtful, finding.text, finding.remedy});
  }
  return verdict;
}

}  // namespace highwall::apps
