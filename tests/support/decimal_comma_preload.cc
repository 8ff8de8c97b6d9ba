// Preloaded into a program (LD_PRELOAD), so that its process has decimal commas from the start, as
// if a library loaded by it had set a locale. DECIMAL_COMMA selects the method.
#include <clocale>
#include <cstdlib>
#include <exception>
#include <locale>
#include <string_view>

#include "support/german_numbers.h"

namespace highwall::testing {
namespace {

constexpr const char* kGerman = "de_DE.UTF-8";
constexpr int kNoLocale = 99;  // exit code

bool SetLocale() {
  const char* const how = std::getenv("DECIMAL_COMMA");
  const std::string_view way = how != nullptr ? how : "";
  try {
    if (way == "setlocale" && std::setlocale(LC_ALL, kGerman) == nullptr) std::_Exit(kNoLocale);
    if (way == "global") std::locale::global(std::locale(kGerman));
    if (way == "facet") std::locale::global(WithGermanNumbers());
  } catch (const std::exception&) {
    std::_Exit(kNoLocale);
  }
  return true;
}

const bool kIsSet = SetLocale();

}  // namespace
}  // namespace highwall::testing
