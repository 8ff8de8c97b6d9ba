#pragma once

#include <string>

namespace CLI {
class App;
class Error;
}  // namespace CLI

namespace highwall::apps {

// "highwall eval", or "highwall" where no subcommand was recognised.
std::string CommandName(const CLI::App& app);

// What is wrong with a call, as one line with its end: what is misspelt before what is missing by
// that.
std::string UsageError(const CLI::App& app, const CLI::Error& error);

}  // namespace highwall::apps
