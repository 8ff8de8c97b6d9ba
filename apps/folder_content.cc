#include "folder_content.h"

#include <algorithm>
#include <fstream>
#include <string>
#include <system_error>

#include <nlohmann/json.hpp>

#include "run_output.h"

namespace highwall::apps {
namespace {

namespace fs = std::filesystem;

// Not open for what is no file: to read a pipe might take for ever.
std::ifstream Opened(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error) ? std::ifstream(path) : std::ifstream();
}

// Not an object where there is none, or it is damaged.
nlohmann::json ReadJson(const fs::path& path) {
  std::ifstream stream = Opened(path);
  return stream.is_open() ? nlohmann::json::parse(stream, nullptr, false) : nlohmann::json();
}

bool HasReportOfRun(const fs::path& folder) {
  const nlohmann::json report = ReadJson(folder / kReportFile);
  return report.is_object() && report.contains(nlohmann::json::json_pointer("/versions/highwall"));
}

// Older versions left no lock.
bool HasLogOfKilledRun(const fs::path& folder) {
  std::string title;
  std::ifstream stream = Opened(folder / kCausalFile);
  return std::getline(stream, title) && title == "# stamp tx ty tz qx qy qz qw";
}

bool HasReportOfMaps(const fs::path& folder) {
  const nlohmann::json report = ReadJson(folder / kMapsReportFile);
  return report.is_object() && report.contains("cloud_over_octree");
}

bool IsBare(const fs::path& folder) {
  std::error_code error;
  const fs::directory_iterator entries(folder, error);
  return !error && std::ranges::all_of(entries, [](const fs::directory_entry& entry) {
    return entry.path().filename().string().starts_with('.');
  });
}

}  // namespace

FolderContent ContentOf(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error) || IsBare(folder)) return FolderContent::kNothing;
  if (HasReportOfRun(folder) || HasLogOfKilledRun(folder)) return FolderContent::kRun;
  if (HasReportOfMaps(folder)) return FolderContent::kMaps;
  return fs::exists(folder / kLockFile, error) ? FolderContent::kUnfinished
                                               : FolderContent::kForeign;
}

}  // namespace highwall::apps
