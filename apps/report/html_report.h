#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "report/run_data.h"

namespace highwall::apps {

// Whether three.js is embedded in this program: without it, pages show a message instead of the 3-D
// view.
bool HasView3d();
inline constexpr const char* kNoView3d =
    "this highwall was built without three.js (Debian: libjs-three)";

// Returns the page: page/report.html with its style, its scripts and the data. Text in the data is
// escaped so that it remains data.
std::string HtmlPage(std::string_view title, const nlohmann::json& data);

// Returns one page of one run or several side by side. The points of the cloud are divided among
// the runs, so that the page does not grow with their number. Throws IoError as RunData().
std::string HtmlReport(std::span<const std::filesystem::path> runs, RunDataOptions options = {});
// Writes a page atomically. Throws IoError.
void WriteHtml(const std::filesystem::path& path, const std::string& page);

}  // namespace highwall::apps
