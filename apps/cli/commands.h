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

// Action of a subcommand after its options are parsed; returns an ExitCode. It may throw: main()
// prints IoError and InvalidArgument as one line and exits with kExitData, any other exception with
// kExitFailed.
using CommandAction = std::function<int()>;

// Runs `highwall WORDS...`, prints errors, and returns an ExitCode.
int RunCommand(std::vector<std::string> words);

// Replaces control characters: messages quote the content of files, whose line breaks and escape
// sequences must not reach the terminal.
inline std::string OneLine(std::string message) {
  std::replace_if(
      message.begin(), message.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }, '?');
  return message;
}

// Prints one line to standard error: "highwall eval: warning: ...".
void PrintWarning(const std::string& command, const std::string& text);

// One function per subcommand, each in its own file. It adds the subcommand and its options to
// `app` and sets `action` if the user chose it. Parsing throws CLI::ParseError for wrong usage.
// `action` must outlive the parsing.
void AddCalibrateCommand(CLI::App& app, CommandAction& action);
void AddConvertCommand(CLI::App& app, CommandAction& action);
void AddDemoCommand(CLI::App& app, CommandAction& action);
void AddEvalCommand(CLI::App& app, CommandAction& action);
void AddImuNoiseCommand(CLI::App& app, CommandAction& action);
void AddInfoCommand(CLI::App& app, CommandAction& action);
void AddLiveCommand(CLI::App& app, CommandAction& action);
void AddMapCommand(CLI::App& app, CommandAction& action);
void AddMergeCommand(CLI::App& app, CommandAction& action);
void AddPosegraphCommand(CLI::App& app, CommandAction& action);
void AddReportCommand(CLI::App& app, CommandAction& action);
void AddSimulateCommand(CLI::App& app, CommandAction& action);
void AddSlamCommand(CLI::App& app, CommandAction& action);

}  // namespace highwall::apps
