#pragma once

#include "commands.h"

namespace highwall::apps {

// highwall map compare: adds it to the command `map`.
void AddMapCompareCommand(CLI::App& map, CommandAction& action);

}  // namespace highwall::apps
