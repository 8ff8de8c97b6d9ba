#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>

#include <highwall/core/trajectory.h>

namespace [[gnu::visibility("default")]] highwall {

// A trajectory file that is appended to pose by pose, in the format of WriteTumTrajectory(). When
// Append() returns, the pose is with the operating system and survives the end of the process.
class TrajectoryLog {
 public:
  // Replaces an existing file at `path`. Throws IoError.
  explicit TrajectoryLog(const std::filesystem::path& path);

  // Throws InvalidArgument for a pose that is not finite or a stamp that decreases, IoError if the
  // file cannot be written: it then ends with the previous pose, and all later calls throw.
  void Append(const StampedPose& pose);

  const std::filesystem::path& path() const { return path_; }

 private:
  void Put(std::string_view text);

  std::filesystem::path path_;
  std::ofstream stream_;
  std::uintmax_t size_ = 0;  // [byte] of complete lines
  std::optional<Stamp> last_;
};

}  // namespace highwall
