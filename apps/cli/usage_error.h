#pragma once

#include <string>

namespace CLI {
class App;
class Error;
}  // namespace CLI

namespace highwall::apps {

// "highwall eval", or "highwall" where no subcommand was recognised.
std::string CommandName(const CLI::App& app);

// Describes a usage error in one line with line end. A misspelt word is reported before the missing
// option that it causes.
std::string UsageError(const CLI::App& app, const CLI::Error& error);

}  // namespace highwall::apps
