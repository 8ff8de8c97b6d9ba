#pragma once

#include "cli/commands.h"

namespace highwall::apps {

// Adds `highwall map compare` to the command `map`.
void AddMapCompareCommand(CLI::App& map, CommandAction& action);

}  // namespace highwall::apps
