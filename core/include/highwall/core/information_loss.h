#pragma once

#include <span>
#include <vector>

#include <highwall/core/marginalization.h>

namespace highwall {

struct InformationLossOptions {
  // Standard deviation of the reference against which information is counted, in tangent units
  // (m, rad, m/s). > 0. Directions that are known no better than this count for nothing, so that
  // the logarithm is finite without a gauge.
  double reference_sigma = 10.0;
  MarginalizationOptions marginalization{};

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// What each candidate to leave the window would take with it: the information [nats] about the
// other candidates' blocks that rests on the residuals touching it (docs/marginalization.md,
// Eq. 12),
//
//   I_c = (log det(I + s^2 Lambda) - log det(I + s^2 Lambda_without_c)) / 2  >= 0,
//
// Lambda and Lambda_without_c: information of the blocks of all candidates but c, everything else
// (landmarks, calibration, c) marginalized, with all residuals and with those of c left out.
// A candidate: the blocks of one instant, such as pose, velocity and bias of a keyframe. The least
// one is the most redundant. Throws InvalidArgument as Marginalize; a block may belong to one
// candidate only.
std::vector<double> InformationLoss(const ceres::Problem& problem,
                                    std::span<const std::vector<double*>> candidates,
                                    const InformationLossOptions& options = {});

}  // namespace highwall
