#include <highwall/internal/option_table.h>

#include <cmath>

#include <highwall/internal/number_text.h>

namespace highwall {

std::string FormatOption(double value) {
  return NumberText(value);
}

std::string OptionRange::ToString() const {
  const bool bounded = !std::isinf(max);
  if (!bounded) return (above ? "> " : ">= ") + FormatOption(min);
  return std::string("in ") + (above ? "(" : "[") + FormatOption(min) + ", " + FormatOption(max) +
         (below ? ")" : "]");
}

}  // namespace highwall
