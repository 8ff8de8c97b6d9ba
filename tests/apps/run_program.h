#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "../frontend/generated_tum.h"

// Programs as their users run them.
namespace highwall::testing {

struct Outcome {
  int exit_code = -1;
  std::string out, err;
};

inline std::string ReadText(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Standard input is empty.
inline Outcome RunProgram(const std::string& program, const std::string& arguments) {
  const TemporaryDirectory scratch("output");
  const std::string out = scratch.path() / "out", err = scratch.path() / "err";
  const std::string command = program + " " + arguments + " < /dev/null > " + out + " 2> " + err;
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, ReadText(out), ReadText(err)};
}

}  // namespace highwall::testing
