#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace highwall::bench {

// Implements main() of a benchmark: parses the options of `app`, which has the name of its binary,
// and runs. An exception becomes one line on standard error and an exit code: 1 wrong usage, 2
// IoError, 3 anything else, 130, 143 or 129 if stopped by a signal (apps/cli/stop_signals.h).
int RunBench(CLI::App& app, int argc, char** argv, const std::function<void()>& run);

struct BenchName {
  std::string binary;
  std::string about;  // one line
};
int RunBench(const BenchName& name, int argc, char** argv,
             const std::function<void(CLI::App&)>& add_options, const std::function<void()>& run);

// Does the same with Arguments that add_options(app, arguments) fills and run(arguments) uses.
template <class Arguments, class AddOptions, class Run>
int RunBench(const BenchName& name, int argc, char** argv, AddOptions add_options, Run run) {
  Arguments arguments;
  return RunBench(
      name, argc, argv, [&](CLI::App& app) { add_options(app, arguments); },
      [&] { run(arguments); });
}

// Adds an option that takes some of `known`, separated by commas; `chosen` has its default.
CLI::Option* AddList(CLI::App& app, const std::string& name, std::vector<std::string>& chosen,
                     const std::vector<std::string>& known, const std::string& remark = "");

// Prints one JSON object on one line, or one line per figure: its name, `width` columns wide, and
// its value.
void PrintFigures(const nlohmann::ordered_json& report, bool json, int width);

}  // namespace highwall::bench
