#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace highwall {

// Columns of the fields of a reading in a line.
struct ImuColumns {
  std::size_t stamp = 0;
  std::optional<std::size_t> nanoseconds{};             // if the stamp has two parts, as in ROS
  std::array<std::size_t, 6> values{1, 2, 3, 4, 5, 6};  // gyroscope x y z, accelerometer x y z

  // Whether the accelerometer reads gravity in place of its reaction, as iOS has it.
  bool reversed_accelerometer = false;

  std::size_t count() const;  // minimum number of fields in a line
};

// Returns the fields of a line, trimmed: separated by semicolons if there are any, else by commas,
// else by blanks.
std::vector<std::string_view> ImuFields(std::string_view line);

// Finds the columns by the names in a heading, ignoring units in brackets and the comment sign:
// "w_RS_S_x", "gyro_x", "angular_velocity.x" and the like, and "a_RS_S_x", "acc_x",
// "linear_acceleration.x". Empty unless it names all six; of several sets the first one that is not
// of a magnetometer, an orientation, gravity or a covariance is used. Stray Scanner, which names
// the rates alpha_x, alpha_y and alpha_z, writes the readings of iOS.
std::optional<ImuColumns> FindImuColumns(std::string_view heading);

}  // namespace highwall
