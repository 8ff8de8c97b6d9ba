#pragma once

#include <span>
#include <string>
#include <string_view>

#include "report/resources.h"

namespace highwall::apps {

// Returns the sources of the page of a run (page/).
std::span<const Resource> ViewResources();

// Returns the page: page/live.html with the style and the scripts of the report and its own.
std::string ViewPage(std::string_view title);

}  // namespace highwall::apps
