#pragma once

#include <clocale>
#include <cstdlib>
#include <filesystem>
#include <locale>
#include <string>

#include "support/german_numbers.h"
#include "support/temporary_directory.h"

// Processes with a decimal comma.
namespace highwall::testing {

// Sets the decimal comma by std::locale::global(), without a locale that must be installed.
class DecimalCommaInStreams {
 public:
  DecimalCommaInStreams() : before_(std::locale::global(WithGermanNumbers())) {}
  ~DecimalCommaInStreams() { std::locale::global(before_); }
  DecimalCommaInStreams(const DecimalCommaInStreams&) = delete;
  DecimalCommaInStreams& operator=(const DecimalCommaInStreams&) = delete;

 private:
  const std::locale before_;
};

// The locale de_DE.UTF-8, built if localedef and its sources are installed (Debian: libc-bin,
// locales).
class GermanLocale {
 public:
  static constexpr const char* kName = "de_DE.UTF-8";

  GermanLocale() {
    const std::string command =
        "localedef -i de_DE -f UTF-8 '" + (folder_ / kName).string() + "' > /dev/null 2>&1";
    made_ = std::system(command.c_str()) == 0;
  }
  // False if the test is to be skipped.
  bool IsMade() const { return made_; }
  const std::filesystem::path& folder() const { return folder_.path(); }  // for LOCPATH

 private:
  const TemporaryDirectory folder_{"locale"};
  bool made_ = false;
};
inline constexpr const char* kNoGermanLocale =
    "localedef cannot make de_DE.UTF-8 here: it, or its sources (Debian: locales), are missing";

// Sets the decimal comma of this process by setlocale(), with a locale built for the test.
class DecimalCommaInC {
 public:
  explicit DecimalCommaInC(const GermanLocale& german) {
    ::setenv("LOCPATH", german.folder().c_str(), 1);
    EXPECT_NE(std::setlocale(LC_ALL, GermanLocale::kName), nullptr);
    EXPECT_STREQ(std::localeconv()->decimal_point, ",");
  }
  ~DecimalCommaInC() {
    std::setlocale(LC_ALL, "C");
    ::unsetenv("LOCPATH");
  }
  DecimalCommaInC(const DecimalCommaInC&) = delete;
  DecimalCommaInC& operator=(const DecimalCommaInC&) = delete;
};

}  // namespace highwall::testing
