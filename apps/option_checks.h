#pragma once

#include <cstdlib>
#include <string>
#include <string_view>

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

// off, paper, consistent, or fixed:W with a weight W in (0, 1000].
inline CLI::Validator ImuChoice() {
  return CLI::Validator(
      [](const std::string& text) -> std::string {
        if (text == "off" || text == "paper" || text == "consistent") return "";
        constexpr std::string_view kFixed = "fixed:";
        const std::string problem = "must be off, paper, consistent or fixed:W, is " + text;
        if (!text.starts_with(kFixed)) return problem;
        const std::string weight = text.substr(kFixed.size());
        char* end = nullptr;
        const double value = std::strtod(weight.c_str(), &end);
        if (end == weight.c_str() || *end != '\0') return problem;
        return value > 0.0 && value <= 1000.0 ? "" : "W must be in (0, 1000], is " + weight;
      },
      "");
}

}  // namespace highwall::apps
