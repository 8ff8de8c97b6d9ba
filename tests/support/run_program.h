#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "support/temporary_directory.h"

// Runs programs as a user does.
namespace highwall::testing {

// Removes the progress lines (apps/progress.h), because they depend on the clock.
inline std::string WithoutProgress(const std::string& text) {
  std::string rest;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("... ")) rest += line + (lines.eof() ? "" : "\n");
  }
  return rest;
}

struct Outcome {
  int exit_code = -1;
  std::string out, err;
};

// Runs in `directory`, so that names of files in it need no path. Standard input is empty.
inline Outcome RunProgram(const std::string& program, const std::string& arguments,
                          const std::filesystem::path& directory = ".") {
  const TemporaryDirectory scratch("output");
  const std::string out = scratch / "out", err = scratch / "err";
  const std::string command = "cd '" + directory.string() + "' && " + program + " " + arguments +
                              " < /dev/null > " + out + " 2> " + err;
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, ReadText(out),
          WithoutProgress(ReadText(err))};
}

// A program that runs concurrently with the test, without input and output. It is killed at the
// latest when this object is destroyed, as by `kill -9`.
class BackgroundProgram {
 public:
  BackgroundProgram(std::string program, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), std::move(program));
    std::vector<char*> words;
    for (std::string& argument : arguments) words.push_back(argument.data());
    words.push_back(nullptr);
    process_ = ::fork();
    if (process_ != 0) return;
    ::signal(SIGINT, SIG_DFL);  // a shell makes its background processes ignore SIGINT
    const int nothing = ::open("/dev/null", O_RDWR);
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nothing, stream);
    ::execv(words.front(), words.data());
    ::_exit(127);
  }
  ~BackgroundProgram() { Kill(); }
  BackgroundProgram(const BackgroundProgram&) = delete;
  BackgroundProgram& operator=(const BackgroundProgram&) = delete;

  bool IsRunning() {
    if (!ended_) ended_ = ::waitpid(process_, &status_, WNOHANG) == process_;
    return !ended_;
  }
  void Send(int signal) const { ::kill(process_, signal); }
  // Waits for the end of the program. Returns -1 if a signal ended it.
  int ExitCode() {
    if (!ended_) ended_ = ::waitpid(process_, &status_, 0) == process_;
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : -1;
  }
  void Kill() {
    if (ended_) return;
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
    ended_ = true;
  }

 private:
  pid_t process_ = 0;
  int status_ = 0;
  bool ended_ = false;
};

inline bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

inline std::size_t CountLines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

// Expects one line on standard error that contains every part, and nothing on standard output.
inline void ExpectRefused(const Outcome& outcome, int exit_code,
                          const std::vector<std::string>& parts) {
  EXPECT_EQ(outcome.exit_code, exit_code);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.err.find('\n') + 1, outcome.err.size()) << outcome.err;
  for (const std::string& part : parts) EXPECT_TRUE(Contains(outcome.err, part)) << outcome.err;
}

}  // namespace highwall::testing
