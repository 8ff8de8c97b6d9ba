#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>

#include <highwall/core/trajectory.h>

namespace [[gnu::visibility("default")]] highwall {

// A trajectory file that grows pose by pose, in the form of WriteTumTrajectory(). A pose is in the
// hands of the system when Append() returns, whatever becomes of the process after that.
class TrajectoryLog {
 public:
  // Takes the place of what is at `path`. Throws IoError.
  explicit TrajectoryLog(const std::filesystem::path& path);

  // Throws InvalidArgument for a pose that is not finite or a stamp that decreases, IoError where
  // the file cannot be written: it then ends with the pose before, and all that follows throws.
  void Append(const StampedPose& pose);

  const std::filesystem::path& path() const { return path_; }

 private:
  void Put(std::string_view text);

  std::filesystem::path path_;
  std::ofstream stream_;
  std::uintmax_t size_ = 0;  // [byte] of whole lines
  std::optional<Stamp> last_;
};

}  // namespace highwall
