#pragma once

#include <locale>
#include <string>

namespace highwall::apps {

// While it lives, the process has the locales of C that a program begins with: CLI11 reads numbers
// by strtold and prints defaults by streams. For programs, before their threads begin: both locales
// belong to all of the process.
class ClassicLocale {
 public:
  ClassicLocale();
  ~ClassicLocale();
  ClassicLocale(const ClassicLocale&) = delete;
  ClassicLocale& operator=(const ClassicLocale&) = delete;

 private:
  const std::string c_;  // of setlocale()
  const std::locale cpp_;
};

}  // namespace highwall::apps
