#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <highwall/core/marginalization.h>

namespace highwall::internal {

// As the functions of marginalization.h, for problems whose values are estimates: if a residual
// cannot be evaluated there, or the result is not finite, they return empty and write the reason to
// `fault`. They throw InvalidArgument for all that is wrong at any values.
std::optional<Marginal> TryMarginalize(const ceres::Problem& problem,
                                       std::span<double* const> removed,
                                       const MarginalizationOptions& options, std::string* fault);
std::optional<Marginal> TrySummarize(const ceres::Problem& problem, std::span<double* const> kept,
                                     const MarginalizationOptions& options, std::string* fault);
std::optional<std::vector<double>> TryInformationLoss(
    const ceres::Problem& problem, std::span<const std::vector<double*>> candidates,
    const InformationLossOptions& options, std::string* fault);

}  // namespace highwall::internal
