#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "report/resources.h"

namespace highwall::apps {

// Parts of which pages are assembled, shared by the report and the live view.

// Returns the text of a resource, which must exist.
std::string TextOf(std::span<const Resource> resources, std::string_view name);
// Whether three.js is among the resources of the report.
bool HasThree();
// Returns the script elements of three.js with its licence; empty without three.js.
std::string ThreeScripts();
std::string ScriptElement(const std::string& script);
// Returns the text so that it remains text in an HTML page.
std::string EscapedHtml(std::string_view text);
// Replaces each mark of the page, which must exist, by its text. The marks are in the order of the
// page: they are replaced from the last to the first, so that inserted text is never searched.
std::string FilledPage(std::string page,
                       std::span<const std::pair<std::string_view, std::string>> marks);

}  // namespace highwall::apps
