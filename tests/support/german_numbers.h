#pragma once

#include <locale>
#include <string>

namespace highwall::testing {

// Formats numbers as 1.234,5.
class GermanNumbers : public std::numpunct<char> {
 protected:
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

// For std::locale::global() where no such locale is installed.
inline std::locale WithGermanNumbers() {
  return std::locale(std::locale::classic(), new GermanNumbers);
}

}  // namespace highwall::testing
