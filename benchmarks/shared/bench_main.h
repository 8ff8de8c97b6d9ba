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

// What the main() of a benchmark does: parses the options of `app`, which is named as its binary
// is, and runs. What is thrown becomes one line on standard error and an exit code: 1 wrong usage,
// 2 IoError, 3 anything else, 130, 143 or 129 where a signal has stopped it (apps/stop_signals.h).
int RunBench(CLI::App& app, int argc, char** argv, const std::function<void()>& run);

struct BenchName {
  std::string binary;
  std::string about;  // a line
};
int RunBench(const BenchName& name, int argc, char** argv,
             const std::function<void(CLI::App&)>& add_options, const std::function<void()>& run);

// The same of Arguments that add_options(app, arguments) reads and run(arguments) takes.
template <class Arguments, class AddOptions, class Run>
int RunBench(const BenchName& name, int argc, char** argv, AddOptions add_options, Run run) {
  Arguments arguments;
  return RunBench(
      name, argc, argv, [&](CLI::App& app) { add_options(app, arguments); },
      [&] { run(arguments); });
}

// An option that takes some of `known`, separated by commas; `chosen` holds its default.
CLI::Option* AddList(CLI::App& app, const std::string& name, std::vector<std::string>& chosen,
                     const std::vector<std::string>& known, const std::string& remark = "");

// One JSON object on one line, or a line a figure: its name, `width` columns wide, and its value.
void PrintFigures(const nlohmann::ordered_json& report, bool json, int width);

}  // namespace highwall::bench
