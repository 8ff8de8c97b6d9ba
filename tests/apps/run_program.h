#pragma once

#include <sys/wait.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "../temporary_directory.h"

// Programs as their users run them.
namespace highwall::testing {

struct Outcome {
  int exit_code = -1;
  std::string out, err;
};

// In `directory`, so that names of files in it need no path. Standard input is empty.
inline Outcome RunProgram(const std::string& program, const std::string& arguments,
                          const std::filesystem::path& directory = ".") {
  const TemporaryDirectory scratch("output");
  const std::string out = scratch / "out", err = scratch / "err";
  const std::string command = "cd '" + directory.string() + "' && " + program + " " + arguments +
                              " < /dev/null > " + out + " 2> " + err;
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, ReadText(out), ReadText(err)};
}

inline bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

inline std::size_t CountLines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

// One line on standard error that holds every part, and nothing on standard output.
inline void ExpectRefused(const Outcome& outcome, int exit_code,
                          const std::vector<std::string>& parts) {
  EXPECT_EQ(outcome.exit_code, exit_code);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.err.find('\n') + 1, outcome.err.size()) << outcome.err;
  for (const std::string& part : parts) EXPECT_TRUE(Contains(outcome.err, part)) << outcome.err;
}

}  // namespace highwall::testing
