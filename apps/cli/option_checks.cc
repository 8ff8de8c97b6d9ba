#include "cli/option_checks.h"

#include <algorithm>

#include <fmt/format.h>

#include <highwall/core/error.h>
#include <highwall/internal/did_you_mean.h>
#include <highwall/internal/number_text.h>

namespace highwall::apps {
namespace {

// "points, lines or both"
std::string List(const std::vector<std::string>& words) {
  std::string list;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) list += i + 1 == words.size() ? " or " : ", ";
    list += words[i];
  }
  return list;
}

}  // namespace

CLI::Validator Between(double min, double max) {
  const std::string range = fmt::format("in [{} - {}]", min, max);
  return CLI::Validator(
      [=](const std::string& text) -> std::string {
        const std::optional<double> value = ReadNumber<double>(text);
        if (value && *value >= min && *value <= max) return "";
        return "must be a number " + range + ", is " + text;
      },
      range);
}

CLI::Option* AddTopics(CLI::App* command, BagTopics* topics) {
  return command
      ->add_option_function<std::string>(
          "--topics", [topics](const std::string& text) { *topics = ReadBagTopics(text); },
          "Topics of a bag; those that are left out are guessed: "
          "colour=/a,depth=/b,imu=/c or gyroscope=/d,accelerometer=/e")
      ->type_name("NAME=TOPIC,...")
      ->check(CLI::Validator(
          [](const std::string& text) -> std::string {
            try {
              ReadBagTopics(text);
            } catch (const InvalidArgument& error) {
              return error.what();
            }
            return "";
          },
          ""));
}

CLI::Validator NotEmpty() {
  return CLI::Validator(
      [](const std::string& text) -> std::string { return text.empty() ? "must be given" : ""; },
      "");
}

CLI::Validator OneOf(const std::vector<std::string>& words) {
  return CLI::Validator(
      [words](const std::string& text) -> std::string {
        if (std::ranges::find(words, text) != words.end()) return "";
        return "must be " + List(words) + ", is " + text + DidYouMean(text, words);
      },
      Braces(words));
}

std::string Braces(const std::vector<std::string>& words) {
  return fmt::format("{{{}}}", fmt::join(words, ","));
}

}  // namespace highwall::apps
