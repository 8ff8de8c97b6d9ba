#include "run/recording_examination.h"

#include <highwall/frontend/input/stamp_check.h>

namespace highwall::apps {
namespace {

void ExamineStamps(const Dataset& dataset, SensorVerdict* verdict) {
  for (const StampFinding& finding : CheckStamps(dataset)) {
    verdict->Add({SensorFault::kStamps, Trust::kDoubtful, finding.text, finding.remedy});
  }
}

}  // namespace

SensorVerdict ExamineRecording(const Dataset& dataset, const RgbdSensor& /*sensor*/) {
  SensorVerdict verdict;
  ExamineStamps(dataset, &verdict);
  return verdict;
}

}  // namespace highwall::apps
