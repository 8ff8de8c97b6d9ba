#include <highwall/internal/option_table.h>

#include <array>
#include <charconv>
#include <cmath>

namespace highwall {

std::string FormatOption(double value) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), end};
}

std::string OptionRange::ToString() const {
  const bool bounded = !std::isinf(max);
  if (!bounded) return (above ? "> " : ">= ") + FormatOption(min);
  return std::string("in ") + (above ? "(" : "[") + FormatOption(min) + ", " + FormatOption(max) +
         (below ? ")" : "]");
}

}  // namespace highwall
