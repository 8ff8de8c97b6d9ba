#pragma once

#include <charconv>
#include <locale>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

// Locale-independent conversion of numbers to text and back: with a decimal point and without
// thousands separators, whatever setlocale() and std::locale::global() have set in the process. The
// printf and strtod families and std::to_string of a double follow the former, streams the latter:
// use these functions to write and read.
namespace [[gnu::visibility("default")]] highwall {

// Returns the shortest text that reads back to the same number.
std::string NumberText(double value);
std::string NumberText(float value);
// As "%.<decimals>f", with six decimals as std::to_string has.
std::string FixedText(double value, int decimals = 6);
// As "%.<digits>g".
std::string RoundedText(double value, int digits);

// Returns false unless the whole text is one number, without blanks and a leading '+'.
template <typename Number>
bool ParseNumber(std::string_view text, Number* value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *value);
  return error == std::errc() && end == text.data() + text.size();
}

// Empty unless the whole text is one number. A leading '+' is accepted; blanks are not.
template <typename Number>
std::optional<Number> ReadNumber(std::string_view text) {
  if (text.starts_with('+')) {
    text.remove_prefix(1);
    if (text.starts_with('-')) return std::nullopt;
  }
  Number value{};
  return ParseNumber(text, &value) ? std::optional(value) : std::nullopt;
}

// Returns the parts of a text between any of the separators; empty parts are left out.
std::vector<std::string_view> SplitWords(std::string_view text, std::string_view separators);

// String streams with the classic locale.
class TextWriter : public std::ostringstream {
 public:
  TextWriter() { imbue(std::locale::classic()); }
};
class TextReader : public std::istringstream {
 public:
  explicit TextReader(const std::string& text) : std::istringstream(text) {
    imbue(std::locale::classic());
  }
};

}  // namespace highwall
