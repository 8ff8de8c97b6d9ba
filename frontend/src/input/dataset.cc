#include <highwall/frontend/input/dataset.h>

#include <cmath>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>

namespace highwall {

void DatasetOptions::Validate() const {
  HIGHWALL_REQUIRE(std::isfinite(max_stamp_difference) && max_stamp_difference > 0.0,
                   "DatasetOptions::max_stamp_difference must be positive, got " +
                       FixedText(max_stamp_difference));
  HIGHWALL_REQUIRE(std::isfinite(frame_rate) && frame_rate > 0.0,
                   "DatasetOptions::frame_rate must be positive, got " + FixedText(frame_rate));
}

ImuRecording Dataset::ReadImu(const VideoSpan& video) const {
  const std::optional<std::filesystem::path> file = imu_file();
  HIGHWALL_REQUIRE(file.has_value(), "Dataset::ReadImu: the recording has no IMU");
  return highwall::ReadImu(*file, video);
}

std::optional<RgbdImage> Dataset::Load(std::size_t index) const {
  HIGHWALL_REQUIRE(index < size(), "frame " + std::to_string(index) + " of " +
                                       std::to_string(size()) + " does not exist");
  try {
    return DoLoad(index);
  } catch (const IoError& error) {
    const std::scoped_lock lock(mutex_);
    problems_.emplace(index, error.what());
    return std::nullopt;
  }
}

std::vector<Dataset::Problem> Dataset::problems() const {
  const std::scoped_lock lock(mutex_);
  std::vector<Problem> list;
  for (const auto& [frame, what] : problems_) list.push_back({frame, what});
  return list;
}

std::string Dataset::WithoutGroundTruth(const IoError& error) {
  return std::string(error.what()) + "; the ground truth is not used";
}

}  // namespace highwall
