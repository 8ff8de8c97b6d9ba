#include <highwall/frontend/input/bag_imu.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>

#include <highwall/core/error.h>

#include "input/bag_readings.h"

namespace highwall {
namespace {

// [ns] between two readings of the accelerometer that are joined.
constexpr Stamp kLongestInterpolation = 100'000'000;

// Readings that are not used.
struct UnusedReadings {
  std::size_t damaged = 0, without_stamp = 0;
  std::string first_problem;  // of those that are damaged
};

std::vector<ImuSample> ReadingsOf(const BagFile& bag, std::uint32_t index, bool use_recorded,
                                  UnusedReadings* unused) {
  std::vector<ImuSample> readings;
  const BagTopic& topic = bag.topics()[index];
  for (const BagMessage& message : bag.messages()) {
    if (message.topic != index) continue;
    try {
      const std::vector<std::uint8_t> bytes = bag.Read(message);
      const std::string name = bag.NameOf(message);
      MessageReader reader(bag.path(), name, topic.encoding, bytes);
      const RosImu imu = ReadRosImu(&reader);
      const Stamp stamp = use_recorded ? message.recorded : imu.header.stamp;
      if (stamp == 0) {
        ++unused->without_stamp;
      } else {
        readings.push_back({stamp, imu.gyroscope, imu.accelerometer});
      }
    } catch (const IoError& error) {
      if (++unused->damaged == 1) unused->first_problem = error.what();
    }
  }
  return readings;
}

// "2 damaged (the first: ...), 1 without a stamp"; empty if all readings are used.
std::string TextOf(const UnusedReadings& unused) {
  std::string text;
  if (unused.damaged > 0) {
    text = std::to_string(unused.damaged) + " damaged (the first: " + unused.first_problem + ")";
  }
  if (unused.without_stamp > 0) {
    text += (text.empty() ? "" : ", ") + std::to_string(unused.without_stamp) + " without a stamp";
  }
  return text;
}

}  // namespace

std::vector<ImuSample> JoinReadings(std::vector<ImuSample> gyroscope,
                                    std::vector<ImuSample> accelerometer) {
  std::ranges::stable_sort(accelerometer, {}, &ImuSample::stamp);
  std::vector<ImuSample> joined;
  for (ImuSample& reading : gyroscope) {
    const auto after =
        std::ranges::lower_bound(accelerometer, reading.stamp, {}, &ImuSample::stamp);
    if (after == accelerometer.end()) continue;
    if (after->stamp == reading.stamp) {
      reading.accelerometer = after->accelerometer;
    } else {
      if (after == accelerometer.begin()) continue;
      const ImuSample& before = *std::prev(after);
      if (after->stamp - before.stamp > kLongestInterpolation) continue;
      const double share = static_cast<double>(reading.stamp - before.stamp) /
                           static_cast<double>(after->stamp - before.stamp);
      reading.accelerometer = (1.0 - share) * before.accelerometer + share * after->accelerometer;
    }
    joined.push_back(reading);
  }
  return joined;
}

ImuRecording ReadBagReadings(const BagFile& bag, const BagImuTopics& topics, bool use_recorded) {
  ImuRecording recording;
  UnusedReadings unused;
  recording.samples = ReadingsOf(bag, topics.gyroscope, use_recorded, &unused);
  if (!topics.IsOne()) {
    recording.samples = JoinReadings(std::move(recording.samples),
                                     ReadingsOf(bag, topics.accelerometer, use_recorded, &unused));
  }
  const std::string not_used = TextOf(unused);
  if (recording.samples.empty()) {
    throw IoError(
        bag.path(),
        (topics.IsOne() ? std::string("its IMU has no reading that can be used")
                        : "its gyroscope has no readings between those of its accelerometer") +
            (not_used.empty() ? not_used : "; not used are " + not_used) +
            ": run without an IMU, --imu off");
  }
  if (!not_used.empty()) {
    recording.warning = bag.path().string() + ": readings of the IMU are not used: " + not_used;
  }
  return recording;
}

Stamp HeaderStamp(const BagFile& bag, const BagMessage& message) {
  if (message.size < BagMessage::kHead) return 0;
  return StampInHead(bag.topics()[message.topic].encoding, message.head);
}

bool LackStamps(const BagFile& bag, std::span<const std::uint32_t> topics) {
  return std::ranges::any_of(topics, [&](std::uint32_t topic) {
    std::size_t messages = 0, without = 0;
    for (const BagMessage& message : bag.messages()) {
      if (message.topic != topic || message.size < BagMessage::kHead) continue;
      ++messages;
      if (HeaderStamp(bag, message) == 0) ++without;
    }
    return 2 * without > messages;
  });
}

ImuRecording ReadBagImu(const std::filesystem::path& path, const BagTopics& topics) {
  const std::unique_ptr<BagFile> bag = OpenBag(path);
  const std::optional<BagImuTopics> imu = ChooseImu(*bag, topics, "");
  if (!imu) throw IoError(path, "holds no readings of an IMU" + ListOfTopics(*bag));
  return ReadBagReadings(*bag, *imu,
                         LackStamps(*bag, std::array{imu->gyroscope, imu->accelerometer}));
}

}  // namespace highwall
