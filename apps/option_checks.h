#pragma once

#include <cstdlib>
#include <string>

#include <fmt/format.h>
#include <CLI/Validators.hpp>

namespace highwall::apps {

// A number in [min, max]. CLI::Range lets NaN pass.
inline CLI::Validator Between(double min, double max) {
  const std::string range = fmt::format("in [{} - {}]", min, max);
  return CLI::Validator(
      [=](const std::string& text) -> std::string {
        char* end = nullptr;
        const double value = std::strtod(text.c_str(), &end);
        if (end != text.c_str() && *end == '\0' && value >= min && value <= max) return "";
        return "must be a number " + range + ", is " + text;
      },
      range);
}

// The name of a file or folder.
inline CLI::Validator NotEmpty() {
  return CLI::Validator(
      [](const std::string& text) -> std::string { return text.empty() ? "must be given" : ""; },
      "");
}

}  // namespace highwall::apps
