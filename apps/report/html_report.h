#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "report/run_data.h"

namespace highwall::apps {

// Whether three.js is embedded in this program: without it pages have no 3-D view, and say so.
bool HasView3d();
inline constexpr const char* kNoView3d =
    "this highwall was built without three.js (Debian: libjs-three)";

// The page: page/report.html with its style, its scripts and the data in it. Whatever text is in
// the data stays data.
std::string HtmlPage(std::string_view title, const nlohmann::json& data);

// One page of one run or several side by side, whole or not at all; the points of the cloud are
// shared out among them, so that the page does not grow with their number. Throws IoError as
// RunData, and where the file cannot be written.
void WriteHtmlReport(const std::filesystem::path& path, std::span<const std::filesystem::path> runs,
                     RunDataOptions options = {});

}  // namespace highwall::apps
