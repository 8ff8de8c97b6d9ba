#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/frontend/input/dataset.h>

namespace highwall {
namespace {

using TopicField = std::pair<std::string_view, std::string BagTopics::*>;

constexpr std::array<TopicField, 5> kTopicFields{{{"colour", &BagTopics::colour},
                                                  {"depth", &BagTopics::depth},
                                                  {"imu", &BagTopics::imu},
                                                  {"gyroscope", &BagTopics::gyroscope},
                                                  {"accelerometer", &BagTopics::accelerometer}}};

void SetTopic(std::string_view entry, BagTopics* topics) {
  const std::size_t equals = entry.find('=');
  const std::string_view name = entry.substr(0, equals);
  for (const auto& [known, member] : kTopicFields) {
    if (name != known) continue;
    const std::string_view topic =
        equals == std::string_view::npos ? std::string_view() : entry.substr(equals + 1);
    HIGHWALL_REQUIRE(!topic.empty(), std::string(known) + " needs a topic, such as " +
                                         std::string(known) + "=/name");
    HIGHWALL_REQUIRE((topics->*member).empty(),
                     "the topic " + std::string(known) + " is given twice");
    topics->*member = topic;
    return;
  }
  throw InvalidArgument("'" + std::string(name) +
                        "' is none of the topics colour, depth, imu, gyroscope and accelerometer");
}

}  // namespace

BagTopics ReadBagTopics(std::string_view text) {
  BagTopics topics;
  while (!text.empty()) {
    const std::size_t comma = std::min(text.find(','), text.size());
    SetTopic(text.substr(0, comma), &topics);
    text.remove_prefix(std::min(comma + 1, text.size()));
  }
  HIGHWALL_REQUIRE(topics.gyroscope.empty() == topics.accelerometer.empty(),
                   "the topics gyroscope and accelerometer need each other");
  HIGHWALL_REQUIRE(topics.imu.empty() || topics.gyroscope.empty(),
                   "the topic imu has both sensors; leave gyroscope and accelerometer out");
  return topics;
}

std::string ToText(const BagTopics& topics) {
  std::string text;
  for (const auto& [name, member] : kTopicFields) {
    if ((topics.*member).empty()) continue;
    text += (text.empty() ? "" : ",") + std::string(name) + "=" + topics.*member;
  }
  return text;
}

}  // namespace highwall
