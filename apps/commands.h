#pragma once

#include <algorithm>
#include <cctype>
#include <functional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace highwall::apps {

enum ExitCode { kExitOk = 0, kExitUsage = 1, kExitData = 2, kExitFailed = 3 };

// What a subcommand does once its options are parsed; returns an ExitCode. It may throw: main()
// prints IoError and InvalidArgument as one line and exits with kExitData, any other exception
// with kExitFailed.
using CommandAction = std::function<int()>;

// What `highwall WORDS...` does; returns an ExitCode, and prints what went wrong.
int RunCommand(std::vector<std::string> words);

// Messages quote what stands in files: a line break or an escape sequence there must not reach the
// terminal.
inline std::string OneLine(std::string message) {
  std::replace_if(
      message.begin(), message.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }, '?');
  return message;
}

// On standard error, as one line: "highwall eval: warning: ...".
void PrintWarning(const std::string& command, const std::string& text);

// One function per subcommand, each in its own file: adds the subcommand and its options to `app`,
// and sets `action` when the user chose it. CLI::ParseError means wrong usage. `action` must
// outlive the parsing.
void AddCalibrateCommand(CLI::App& app, CommandAction& action);
void AddDemoCommand(CLI::App& app, CommandAction& action);
void AddEvalCommand(CLI::App& app, CommandAction& action);
void AddImuNoiseCommand(CLI::App& app, CommandAction& action);
void AddInfoCommand(CLI::App& app, CommandAction& action);
void AddMapCommand(CLI::App& app, CommandAction& action);
void AddMergeCommand(CLI::App& app, CommandAction& action);
void AddPosegraphCommand(CLI::App& app, CommandAction& action);
void AddReportCommand(CLI::App& app, CommandAction& action);
void AddSimulateCommand(CLI::App& app, CommandAction& action);
void AddSlamCommand(CLI::App& app, CommandAction& action);

}  // namespace highwall::apps
