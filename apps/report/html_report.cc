#include "report/html_report.h"

#include <utility>

#include <nlohmann/json.hpp>

#include <highwall/core/atomic_file.h>

#include "files/json_text.h"
#include "report/html_page.h"
#include "report/resources.h"

namespace highwall::apps {
namespace {

constexpr std::string_view kScripts[] = {"elements.js", "chart.js",    "plan.js",  "view3d.js",
                                         "compare.js",  "sections.js", "report.js"};

// Escapes JSON so that it cannot end the enclosing script element.
std::string InScript(const nlohmann::json& data) {
  const std::string text = JsonText(data);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    if (c == '<') {
      safe += "\\u003c";
    } else {
      safe += c;
    }
  }
  return safe;
}

std::string Scripts() {
  std::string scripts = ThreeScripts();
  for (const std::string_view name : kScripts) scripts += ScriptElement(TextOf(Resources(), name));
  return scripts;
}

}  // namespace

bool HasView3d() {
  return HasThree();
}

std::string HtmlPage(std::string_view title, const nlohmann::json& data) {
  const std::pair<std::string_view, std::string> marks[] = {
      {"<!-- title -->", EscapedHtml(title)},
      {"/* style */", TextOf(Resources(), "report.css")},
      {"<!-- data -->", InScript(data)},
      {"<!-- scripts -->", Scripts()}};
  return FilledPage(TextOf(Resources(), "report.html"), marks);
}

std::string HtmlReport(std::span<const std::filesystem::path> runs, RunDataOptions options) {
  options.scene.points /= runs.size();
  options.scene.voxels /= runs.size();
  nlohmann::json data = {{"version", HIGHWALL_VERSION}, {"runs", nlohmann::json::array()}};
  std::string title;
  for (const std::filesystem::path& run : runs) {
    data["runs"].push_back(RunData(run, options));
    if (!title.empty()) title += ", ";
    title += ToUtf8(data["runs"].back()["name"].get<std::string>());
  }
  return HtmlPage(title + " - Highwall", data);
}

void WriteHtml(const std::filesystem::path& path, const std::string& page) {
  AtomicFile file(path);
  file.stream() << page;
  file.Commit();
}

}  // namespace highwall::apps
