#include "tracking/tracking_diagnostics.h"

#include <algorithm>

#include "pose/support.h"

namespace highwall {
namespace {

// In an image this dark, the minimum contrast of a corner is a third of the brightness.
constexpr double kDark = 3.0;
// Motion blur that halves the steps between pixels has smeared them over two.
constexpr double kBlurred = 0.5;

}  // namespace

void TrackingDiagnostics::Add(const AttemptDiagnostics& attempt) {
  tried = std::max(tried, attempt.tried);
  agreed = std::max(agreed, attempt.agreed);
  masked_share = attempt.masked_share.value_or(masked_share);
  shift = attempt.shift.value_or(shift);
}

LossReason ReasonOf(const FrameFeatures& features, const TrackingDiagnostics& diagnostics,
                    const FeatureNeeds& needs) {
  const auto with_depth = [](const auto& all, const auto& has_depth) {
    return static_cast<std::size_t>(std::count_if(all.begin(), all.end(), has_depth));
  };
  const auto min_features = static_cast<std::size_t>(needs.min_features);
  const auto sound = std::count_if(features.points.begin(), features.points.end(),
                                   [](const PointFeature& p) { return !p.low_contrast; });
  if (Support(static_cast<std::size_t>(sound), features.lines.size()) < min_features) {
    if (features.brightness < kDark * needs.min_corner) return LossReason::kDark;
    if (features.sharpness < kBlurred * needs.usual_sharpness) return LossReason::kBlurred;
    return LossReason::kPlain;
  }
  if (Support(with_depth(features.points, [](const PointFeature& p) { return p.depth > 0.0; }),
              with_depth(features.lines, [](const LineFeature& l) {
                return l.segment_C.has_value();
              })) < min_features) {
    return LossReason::kNoDepth;
  }
  if (diagnostics.masked_share > 0.5) return LossReason::kAllMoving;
  if (diagnostics.shift > needs.searched) return LossReason::kTooFast;
  if (diagnostics.tried > 2 * std::max(diagnostics.agreed, needs.min_features / 10)) {
    return LossReason::kContradictory;
  }
  return diagnostics.predicted ? LossReason::kDeadReckoning : LossReason::kUnknownPlace;
}

}  // namespace highwall
