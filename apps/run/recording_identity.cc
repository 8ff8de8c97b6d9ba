#include "run/recording_identity.h"

#include <algorithm>
#include <cstdint>
#include <exception>
#include <fstream>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/open_dataset.h>
#include <highwall/frontend/input/tum_dataset.h>

#include "files/json_text.h"
#include "run/run_dataset.h"
#include "run/run_files.h"

namespace highwall::apps {
namespace {

constexpr const char* kIdentityKey = "recording";  // in run.json

// Source: Fowler, Noll, Vo, Eastlake, "The FNV Non-Cryptographic Hash Algorithm", RFC 9923.
std::string HashOfFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return "";
  std::uint64_t hash = 0xcbf29ce484222325;
  for (auto byte = std::istreambuf_iterator<char>(file); byte != std::istreambuf_iterator<char>();
       ++byte) {
    hash = (hash ^ static_cast<unsigned char>(*byte)) * 0x100000001b3;
  }
  return fmt::format("{:016x}", hash);
}

}  // namespace

RecordingIdentity IdentityOf(const Dataset& dataset) {
  if (const auto* const listed = dynamic_cast<const TumDataset*>(&dataset)) {
    const std::vector<TumImageFile>& files = listed->colour_files();
    return {files.size(), files.front().stamp, files.back().stamp, HashOfFile(files.front().path)};
  }
  std::vector<Stamp> stamps = dataset.stamps_without_depth();
  for (std::size_t i = 0; i < dataset.size(); ++i) stamps.push_back(dataset.stamp(i));
  const auto [first, last] = std::ranges::minmax(stamps);
  return {stamps.size(), first, last, ""};
}

nlohmann::json ToJson(const RecordingIdentity& identity) {
  return {{"colour_images", identity.colour_images},
          {"first", FormatStamp(identity.first)},
          {"last", FormatStamp(identity.last)},
          {"first_image", identity.first_image}};
}

std::string DifferenceFromRun(const Dataset& dataset, const nlohmann::json& report) {
  if (!report.is_object() || !report.contains(kIdentityKey)) return "";
  const nlohmann::json now = ToJson(IdentityOf(dataset)), then = report[kIdentityKey];
  if (!then.is_object()) return "";
  const auto differs = [&](const char* key) { return then.contains(key) && then[key] != now[key]; };
  const auto both = [&](const char* key) {
    return std::pair(JsonText(now[key]), JsonText(then[key]));
  };
  if (differs("colour_images")) {
    const auto [has, had] = both("colour_images");
    return "has " + has + " colour images, that of the run had " + had;
  }
  for (const auto& [key, what] : {std::pair("first", "begins"), std::pair("last", "ends")}) {
    if (!differs(key)) continue;
    const auto [has, had] = both(key);
    return fmt::format("{} at {}, that of the run at {}", what, has, had);
  }
  if (differs("first_image") && now["first_image"] != "" && then["first_image"] != "") {
    return "begins with another image than that of the run";
  }
  return "";
}

std::string DifferenceFromRun(const std::filesystem::path& folder, const nlohmann::json& report) {
  try {
    return DifferenceFromRun(*OpenDataset(folder, std::nullopt, InputOptionsOfRun(report)), report);
  } catch (const std::exception&) {  // whoever reads it will say so
    return "";
  }
}

void RequireRecordingOfRun(const std::filesystem::path& folder, const Dataset& dataset,
                           const std::filesystem::path& run) {
  const std::string difference = DifferenceFromRun(dataset, ReadJson(run / kReportFile));
  if (difference.empty()) return;
  throw IoError(folder, "is another recording than that of " + run.string() + ": it " + difference);
}

}  // namespace highwall::apps
