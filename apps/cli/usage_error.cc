#include "cli/usage_error.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <vector>

#include <fmt/core.h>

#include <highwall/internal/did_you_mean.h>

#include "cli/commands.h"

namespace highwall::apps {
namespace {

const CLI::App& Innermost(const CLI::App& app) {
  const auto chosen = app.get_subcommands();
  return chosen.empty() ? app : Innermost(*chosen.front());
}

std::vector<std::string> OptionNames(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

std::vector<std::string> SubcommandNames(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* subcommand : command.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(subcommand->get_name());
  }
  return names;
}

// Returns an empty string if every word was recognised.
std::string Misspelt(const CLI::App& app) {
  const CLI::App& command = Innermost(app);
  for (const std::string& word : app.remaining(true)) {
    if (!word.starts_with("-")) continue;
    const std::string name = word.substr(0, word.find('='));
    return fmt::format("unknown option {}{}", name, DidYouMean(name, OptionNames(command)));
  }
  const std::vector<std::string> left = app.remaining(true);
  if (left.empty() || &command != &app) return "";
  return fmt::format("unknown command {}{}", left.front(),
                     DidYouMean(left.front(), SubcommandNames(app)));
}

}  // namespace

std::string CommandName(const CLI::App& app) {
  const auto chosen = app.get_subcommands();
  return chosen.empty() ? app.get_name() : app.get_name() + " " + chosen.front()->get_name();
}

std::string UsageError(const CLI::App& app, const CLI::Error& error) {
  const std::string command = CommandName(app);
  const std::string misspelt = Misspelt(app);
  return fmt::format("{}: {} (see {} --help)\n", command,
                     OneLine(misspelt.empty() ? error.what() : misspelt), command);
}

}  // namespace highwall::apps
