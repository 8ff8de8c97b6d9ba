#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <highwall/core/stamp.h>
#include <highwall/factors/imu_buffer.h>

namespace highwall {

// The stamps [ns] of the first and the last frame of a video, begin <= end.
struct VideoSpan {
  Stamp begin = 0, end = 0;
};

struct ImuRecording {
  // As the file holds them: not sorted, duplicates and NaN in place, for CheckImu() to find.
  std::vector<ImuSample> samples;
  std::vector<std::int64_t> lines;  // of the file, from 1, one a sample
  std::string warning;              // one line where stamps had to be converted, else empty
};

// The file with the readings of the IMU in the folder of a dataset: imu.csv, imu.txt (ETH3D),
// imu0/data.csv or mav0/imu0/data.csv (EuRoC), the first that is there.
std::optional<std::filesystem::path> FindImuFile(const std::filesystem::path& dataset);

// Lines "stamp, gyroscope x y z [rad/s], accelerometer x y z [m/s^2]", separated by commas or by
// blanks; lines that begin with #, empty lines, CRLF and one heading are allowed, and so are nan
// and inf. Whole numbers are stamps in nanoseconds, decimal ones in seconds; where that is far from
// the video, the unit (s, ms, us, ns) that is not takes its place, with a warning.
// Throws IoError "path:line: what; what to do" for a line of another form, "path: ..." for a file
// that cannot be read or holds no reading, and for stamps that do not meet the video in any unit:
// those of another clock.
// Source of the columns: Burri et al., "The EuRoC micro aerial vehicle datasets", IJRR 35(10),
// 2016; https://www.eth3d.net/slam_documentation
ImuRecording ReadImu(const std::filesystem::path& path, const VideoSpan& video);

}  // namespace highwall
