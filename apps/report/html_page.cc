#include "report/html_page.h"

#include <algorithm>
#include <cstddef>

#include <highwall/core/error.h>

namespace highwall::apps {
namespace {

constexpr std::string_view kThree = "three.min.js";
constexpr std::string_view kOrbit = "OrbitControls.js";
constexpr std::string_view kLicence = "three_licence.txt";

const Resource* FindIn(std::span<const Resource> resources, std::string_view name) {
  const auto at = std::ranges::find(resources, name, &Resource::name);
  return at == resources.end() ? nullptr : &*at;
}

}  // namespace

std::string TextOf(std::span<const Resource> resources, std::string_view name) {
  const Resource* const resource = FindIn(resources, name);
  HIGHWALL_REQUIRE(resource != nullptr, "no such resource: " + std::string(name));
  return {resource->bytes.begin(), resource->bytes.end()};
}

bool HasThree() {
  return FindIn(Resources(), kThree) != nullptr && FindIn(Resources(), kOrbit) != nullptr;
}

std::string ThreeScripts() {
  if (!HasThree()) return "";
  return "<script>\n/*\n" + TextOf(Resources(), kLicence) + "*/\n" + TextOf(Resources(), kThree) +
         "\n" + TextOf(Resources(), kOrbit) + "</script>\n";
}

std::string ScriptElement(const std::string& script) {
  return "<script>\n" + script + "</script>\n";
}

std::string EscapedHtml(std::string_view text) {
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

std::string FilledPage(std::string page,
                       std::span<const std::pair<std::string_view, std::string>> marks) {
  for (auto mark = marks.rbegin(); mark != marks.rend(); ++mark) {
    const std::size_t at = page.find(mark->first);
    HIGHWALL_REQUIRE(at != std::string::npos, "the page has no " + std::string(mark->first));
    page.replace(at, mark->first.size(), mark->second);
  }
  return page;
}

}  // namespace highwall::apps
