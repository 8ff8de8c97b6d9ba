#include "view/view_page.h"

#include <utility>

#include "report/html_page.h"

namespace highwall::apps {
namespace {

constexpr std::string_view kShared[] = {"elements.js", "chart.js", "view3d.js"};
constexpr std::string_view kOwn[] = {"live_image.js", "live_scene.js", "live_curves.js", "live.js"};

}  // namespace

std::string ViewPage(std::string_view title) {
  std::string scripts = ThreeScripts();
  for (const std::string_view name : kShared) scripts += ScriptElement(TextOf(Resources(), name));
  for (const std::string_view name : kOwn) scripts += ScriptElement(TextOf(ViewResources(), name));
  const std::pair<std::string_view, std::string> marks[] = {
      {"<!-- title -->", EscapedHtml(title)},
      {"/* style */", TextOf(Resources(), "report.css") + TextOf(ViewResources(), "live.css")},
      {"<!-- name -->", EscapedHtml(title)},
      {"<!-- version -->", HIGHWALL_VERSION},
      {"<!-- scripts -->", scripts}};
  return FilledPage(TextOf(ViewResources(), "live.html"), marks);
}

}  // namespace highwall::apps
