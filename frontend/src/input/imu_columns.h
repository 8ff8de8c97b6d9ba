#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace highwall {

// Where the fields of a reading stand in a line.
struct ImuColumns {
  std::size_t stamp = 0;
  std::optional<std::size_t> nanoseconds{};             // of a stamp in two parts, as ROS has it
  std::array<std::size_t, 6> values{1, 2, 3, 4, 5, 6};  // gyroscope x y z, accelerometer x y z

  std::size_t count() const;  // fields that a line must have
};

// The fields of a line, trimmed: between semicolons where there are any, else between commas, else
// between blanks.
std::vector<std::string_view> ImuFields(std::string_view line);

// By the names in a heading, of which units in brackets and the sign of a comment are no part:
// "w_RS_S_x", "gyro_x", "angular_velocity.x" and the like, and "a_RS_S_x", "acc_x",
// "linear_acceleration.x". Empty where it does not name all six once; the first of several sets
// that are not of a magnetometer, an orientation, gravity or a covariance counts.
std::optional<ImuColumns> FindImuColumns(std::string_view heading);

}  // namespace highwall
