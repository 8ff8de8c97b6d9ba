#include "run/late_colour.h"

#include <algorithm>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <highwall/core/error.h>

#include "files/json_text.h"

namespace highwall::apps {

nlohmann::json ToJson(const LateColour& late) {
  nlohmann::json json = {{"taken", nlohmann::json::array()}, {"stamp", nlohmann::json::array()}};
  for (const auto& [taken, stamp] : late) {
    json["taken"].push_back(FormatStamp(taken));
    json["stamp"].push_back(FormatStamp(stamp));
  }
  return json;
}

LateColour ReadLateColour(const std::filesystem::path& run_json) {
  const nlohmann::json report = ReadJson(run_json);
  if (!report.is_object() || !report.contains("late_colour")) return {};
  LateColour late;
  try {
    const auto taken = report["late_colour"].at("taken").get<std::vector<std::string>>();
    const auto stamps = report["late_colour"].at("stamp").get<std::vector<std::string>>();
    for (std::size_t i = 0; i < std::min(taken.size(), stamps.size()); ++i) {
      const auto key = ParseStamp(taken[i]), value = ParseStamp(stamps[i]);
      if (key && value) late[*key] = *value;
    }
  } catch (const nlohmann::json::exception& error) {
    throw IoError(run_json, std::string("is not that of a run: ") + error.what());
  }
  return late;
}

std::optional<std::size_t> ImageOfColour(const LateColour& late, const Dataset& dataset,
                                         Stamp stamp) {
  const auto found = late.find(stamp);
  if (found == late.end()) return std::nullopt;
  for (std::size_t i = 0; i < dataset.size(); ++i) {
    if (dataset.stamp(i) == found->second) return i;
  }
  return std::nullopt;
}

}  // namespace highwall::apps
