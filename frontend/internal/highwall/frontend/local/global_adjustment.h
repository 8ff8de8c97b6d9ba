#pragma once

#include <highwall/frontend/local/options.h>

namespace [[gnu::visibility("default")]] highwall {

// Options of an adjustment of a whole map. Few steps: a pose graph has brought the map near the
// optimum, and local adjustments continue. Almost Gauss-Newton steps: a small trust region would
// leave the bend of a long loop (BundleAdjustmentOptions::trust_region).
inline constexpr BundleAdjustmentOptions kGlobalAdjustment{
    .first_iterations = 4, .second_iterations = 4, .trust_region = 1e8};

}  // namespace highwall
