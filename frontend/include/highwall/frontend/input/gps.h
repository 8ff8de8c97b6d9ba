#pragma once

#include <filesystem>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/stamp.h>

namespace [[gnu::visibility("default")]] highwall {

// A measured position of an antenna, in a frame G whose axes are east, north and up, or another
// right-handed frame with z up.
struct GpsFix {
  Stamp stamp = 0;        // [ns] of the clock of the images
  Eigen::Vector3d p_G;    // [m]
  Eigen::Vector3d sigma;  // [m] > 0, by axis
};

// Lines "stamp [s], x y z [m]" or, where the heading names lat, "stamp [s], latitude longitude
// [deg], altitude [m]" (WGS 84), and then the sigmas of east, north and up [m], or none of them:
// 2.5 m and 5 m up, a receiver without corrections. Separated by commas or blanks; the heading may
// begin with #, and so may comments. Latitudes become metres east, north and up of the first fix. A
// fix with a nan is none. In the order of the stamps.
// Throws IoError "path:line: what; what to do" for a line of another form, and "path: ..." for a
// file that cannot be read or holds no fix.
std::vector<GpsFix> ReadGps(const std::filesystem::path& path);

}  // namespace highwall
