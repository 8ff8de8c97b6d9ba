#include <highwall/frontend/input/bag_imu.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include <highwall/core/error.h>

#include "input/bag_readings.h"

namespace highwall {
namespace {

// [ns] between two readings of the accelerometer that are joined.
constexpr Stamp kLongestInterpolation = 100'000'000;

std::vector<ImuSample> ReadingsOf(const BagFile& bag, std::uint32_t index, bool use_recorded) {
  std::vector<ImuSample> readings;
  const BagTopic& topic = bag.topics()[index];
  for (const BagMessage& message : bag.messages()) {
    if (message.topic != index) continue;
    const std::vector<std::uint8_t> bytes = bag.Read(message);
    const std::string name = bag.NameOf(message);
    MessageReader reader(bag.path(), name, topic.encoding, bytes);
    const RosImu imu = ReadRosImu(&reader);
    readings.push_back(
        {use_recorded ? message.recorded : imu.header.stamp, imu.gyroscope, imu.accelerometer});
  }
  return readings;
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
  recording.samples = ReadingsOf(bag, topics.gyroscope, use_recorded);
  if (!topics.IsOne()) {
    recording.samples = JoinReadings(std::move(recording.samples),
                                     ReadingsOf(bag, topics.accelerometer, use_recorded));
  }
  if (recording.samples.empty()) {
    throw IoError(bag.path(),
                  "its gyroscope has no readings between those of its accelerometer: "
                  "run without an IMU, --imu off");
  }
  return recording;
}

bool LacksStamps(const BagFile& bag, std::uint32_t topic) {
  const BagMessage* const first = bag.FirstOf(topic);
  return first != nullptr && StampInHead(bag.topics()[topic].encoding, first->head) == 0;
}

ImuRecording ReadBagImu(const std::filesystem::path& path, const BagTopics& topics) {
  const std::unique_ptr<BagFile> bag = OpenBag(path);
  const std::optional<BagImuTopics> imu = ChooseImu(*bag, topics, "");
  if (!imu) throw IoError(path, "holds no readings of an IMU" + ListOfTopics(*bag));
  return ReadBagReadings(*bag, *imu, LacksStamps(*bag, imu->gyroscope));
}

}  // namespace highwall
