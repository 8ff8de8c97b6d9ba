#include "features/corrected_depth.h"

#include "features/feature_kinds.h"

namespace highwall {

std::shared_ptr<const FrameFeatures> CorrectedDepth(const FrameFeatures& features,
                                                    const PinholeCamera& camera,
                                                    const DepthPattern& pattern) {
  const DepthFactor factor(camera, pattern);
  auto corrected = std::make_shared<FrameFeatures>(features);
  ForEachKindOfFeature(
      [&](auto& list) {
        for (auto& feature : list) CorrectDepth(factor, &feature);
      },
      *corrected);
  return corrected;
}

}  // namespace highwall
