#pragma once

#include <charconv>
#include <locale>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>

// Numbers as text and back: with a decimal point and without separators of thousands, whatever
// setlocale() and std::locale::global() have set in the process. The printf and strtod families and
// std::to_string of a double follow the one, streams follow the other: write and read by these.
namespace [[gnu::visibility("default")]] highwall {

// The shortest text that reads back to the same number.
std::string NumberText(double value);
std::string NumberText(float value);
// As "%.<decimals>f", with six decimals as std::to_string has.
std::string FixedText(double value, int decimals = 6);
// As "%.<digits>g".
std::string RoundedText(double value, int digits);

// Empty unless all of the text is one number. A '+' may stand before it; blanks may not.
template <typename Number>
std::optional<Number> ReadNumber(std::string_view text) {
  if (text.starts_with('+')) {
    text.remove_prefix(1);
    if (text.starts_with('-')) return std::nullopt;
  }
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// std::ostringstream and std::istringstream.
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
