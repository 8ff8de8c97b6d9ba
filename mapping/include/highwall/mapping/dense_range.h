#pragma once

namespace highwall {

// [m] Depth farther away makes no map, unless options say otherwise: a D435i's noise is 14 cm
// there.
inline constexpr double kDenseRange = 6.0;

}  // namespace highwall
