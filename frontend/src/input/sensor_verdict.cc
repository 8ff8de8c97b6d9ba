#include <highwall/frontend/input/sensor_verdict.h>

#include <algorithm>
#include <utility>

namespace highwall {

const char* ToString(SensorFault fault) {
  switch (fault) {
    case SensorFault::kDepthScale:
      return "depth scale";
    case SensorFault::kDepthConstant:
      return "constant depth";
    case SensorFault::kDepthSaturated:
      return "saturated depth";
    case SensorFault::kDepthByteOrder:
      return "byte order of depth";
    case SensorFault::kDepthInverse:
      return "inverse depth";
    case SensorFault::kDepthMirrored:
      return "mirrored depth";
    case SensorFault::kDepthUnregistered:
      return "unregistered depth";
    case SensorFault::kDepthInconsistent:
      return "inconsistent depth";
    case SensorFault::kLens:
      return "lens";
    case SensorFault::kImuMount:
      return "imu mount";
    case SensorFault::kImuLeverArm:
      return "imu lever arm";
    case SensorFault::kImuAxes:
      return "imu axes";
    case SensorFault::kImuSign:
      return "imu sign";
    case SensorFault::kImuScale:
      return "imu scale";
    case SensorFault::kImuClock:
      return "imu clock";
    case SensorFault::kImuReadings:
      return "imu readings";
    case SensorFault::kImuInconsistent:
      return "inconsistent imu";
    case SensorFault::kStamps:
      return "stamps";
    case SensorFault::kMapNotMet:
      return "map not met";
    case SensorFault::kEmptyMap:
      return "empty map";
  }
  return "unknown";
}

const char* ToString(Trust trust) {
  switch (trust) {
    case Trust::kConsistent:
      return "consistent";
    case Trust::kDoubtful:
      return "doubtful";
    case Trust::kNotTrusted:
      return "not to be trusted";
  }
  return "unknown";
}

std::string Line(const SensorFinding& finding) {
  return finding.remedy.empty() ? finding.text : finding.text + ": " + finding.remedy;
}

Trust SensorVerdict::trust() const {
  Trust worst = Trust::kConsistent;
  for (const SensorFinding& finding : findings) worst = std::max(worst, finding.trust);
  return worst;
}

bool SensorVerdict::Add(SensorFinding finding) {
  const auto same = std::ranges::find(findings, finding.fault, &SensorFinding::fault);
  if (same == findings.end()) {
    findings.push_back(std::move(finding));
    return true;
  }
  if (finding.trust <= same->trust) return false;
  *same = std::move(finding);
  return true;
}

std::string SensorVerdict::Summary() const {
  const Trust all = trust();
  std::string summary = ToString(all);
  if (all == Trust::kConsistent) return summary;
  const auto worst = std::ranges::find(findings, all, &SensorFinding::trust);
  summary += ": " + Line(*worst);
  if (findings.size() > 1) {
    summary += " (and " + std::to_string(findings.size() - 1) + " more, above)";
  }
  return summary;
}

}  // namespace highwall
