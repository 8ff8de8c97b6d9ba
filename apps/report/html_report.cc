#include "report/html_report.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>

#include "files/json_text.h"
#include "report/resources.h"

namespace highwall::apps {
namespace {

constexpr std::string_view kThree = "three.min.js";
constexpr std::string_view kOrbit = "OrbitControls.js";
constexpr std::string_view kScripts[] = {"elements.js", "chart.js",    "plan.js",  "view3d.js",
                                         "compare.js",  "sections.js", "report.js"};
constexpr std::string_view kLicence = "three_licence.txt";

const Resource* Find(std::string_view name) {
  const auto resources = Resources();
  const auto at = std::ranges::find(resources, name, &Resource::name);
  return at == resources.end() ? nullptr : &*at;
}

std::string Text(std::string_view name) {
  const Resource* const resource = Find(name);
  HIGHWALL_REQUIRE(resource != nullptr, "no such resource: " + std::string(name));
  return {resource->bytes.begin(), resource->bytes.end()};
}

std::string Escaped(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&') {
      escaped += "&amp;";
    } else if (c == '<') {
      escaped += "&lt;";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

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
  std::string scripts;
  if (HasView3d()) {
    scripts += "<script>\n/*\n" + Text(kLicence) + "*/\n";
    scripts += Text(kThree) + "\n" + Text(kOrbit) + "</script>\n";
  }
  for (const std::string_view name : kScripts) scripts += "<script>\n" + Text(name) + "</script>\n";
  return scripts;
}

}  // namespace

bool HasView3d() {
  return Find(kThree) != nullptr && Find(kOrbit) != nullptr;
}

std::string HtmlPage(std::string_view title, const nlohmann::json& data) {
  std::string page = Text("report.html");
  // From the last to the first mark, so that inserted text is never searched.
  const auto fill = [&page](std::string_view mark, const std::string& text) {
    const std::size_t at = page.find(mark);
    HIGHWALL_REQUIRE(at != std::string::npos, "report.html has no " + std::string(mark));
    page.replace(at, mark.size(), text);
  };
  fill("<!-- scripts -->", Scripts());
  fill("<!-- data -->", InScript(data));
  fill("/* style */", Text("report.css"));
  fill("<!-- title -->", Escaped(title));
  return page;
}

void WriteHtmlReport(const std::filesystem::path& path, std::span<const std::filesystem::path> runs,
                     RunDataOptions options) {
  options.scene.points /= runs.size();
  options.scene.voxels /= runs.size();
  nlohmann::json data = {{"version", HIGHWALL_VERSION}, {"runs", nlohmann::json::array()}};
  std::string title;
  for (const std::filesystem::path& run : runs) {
    data["runs"].push_back(RunData(run, options));
    if (!title.empty()) title += ", ";
    title += ToUtf8(data["runs"].back()["name"].get<std::string>());
  }
  AtomicFile file(path);
  file.stream() << HtmlPage(title + " - Highwall", data);
  file.Commit();
}

}  // namespace highwall::apps
