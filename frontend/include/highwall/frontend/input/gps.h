#pragma once

#include <filesystem>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/stamp.h>

namespace [[gnu::visibility("default")]] highwall {

// A measured position of an antenna, in a frame G whose axes point east, north and up, or in
// another right-handed frame with z up.
struct GpsFix {
  Stamp stamp = 0;        // [ns] of the clock of the images
  Eigen::Vector3d p_G;    // [m]
  Eigen::Vector3d sigma;  // [m] > 0, per axis
};

// Reads lines "stamp [s], x y z [m]" or, where the heading names lat, "stamp [s], latitude
// longitude [deg], altitude [m]" (WGS 84), optionally followed by the sigmas of east, north and up
// [m]; the default is 2.5 m and 5 m up, a receiver without corrections. Fields are separated by
// commas or blanks; comments and the heading may begin with #. Geodetic coordinates are converted
// to metres east, north and up of the first fix. A fix with a nan is skipped. Returns the fixes in
// the order of their stamps.
// Throws IoError "path:line: what; what to do" for a line of another form, and "path: ..." for a
// file that cannot be read or holds no fix.
std::vector<GpsFix> ReadGps(const std::filesystem::path& path);

}  // namespace highwall
