#include "run/folder_content.h"

#include <algorithm>
#include <fstream>
#include <string>
#include <system_error>

#include <nlohmann/json.hpp>

#include "files/json_text.h"
#include "run/run_files.h"

namespace highwall::apps {
namespace {

namespace fs = std::filesystem;

bool HasReportOfRun(const fs::path& folder) {
  const nlohmann::json report = ReadJson(folder / kReportFile);
  return report.is_object() && report.contains(nlohmann::json::json_pointer("/versions/highwall"));
}

// Older versions did not create a lock file.
bool HasLogOfKilledRun(const fs::path& folder) {
  std::string title;
  std::error_code error;
  if (!fs::is_regular_file(folder / kCausalFile, error)) return false;
  std::ifstream stream(folder / kCausalFile);
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
