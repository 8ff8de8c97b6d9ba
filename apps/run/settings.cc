#include "run/settings.h"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

#include <fmt/format.h>

#include <highwall/core/error.h>
#include <highwall/frontend/input/yaml_reader.h>
#include <highwall/frontend/system/option_table.h>
#include <highwall/internal/did_you_mean.h>

#include "run/former_settings.h"

namespace highwall::apps {
namespace {

template <class Field>
concept Group = std::is_class_v<Field>;
template <class Field>
concept Enum = std::is_enum_v<Field>;

template <Enum Field>
std::vector<std::string> Words() {
  std::vector<std::string> words;
  for (const Field choice : kChoices<Field>) words.push_back(ToString(choice));
  return words;
}

// Human-readable description of the valid values of a setting.
template <class Field>
std::string Demand() {
  if constexpr (Enum<Field>) {
    return fmt::format("one of {}", fmt::join(Words<Field>(), ", "));
  } else if constexpr (std::is_same_v<Field, bool>) {
    return "true or false";
  } else if constexpr (std::is_integral_v<Field>) {
    return "an integer";
  } else {
    return "a number";
  }
}

// Returns false if the text is not a valid value.
template <class Field>
bool Parse(const std::string& text, Field* field) {
  if constexpr (Enum<Field>) {
    for (const Field choice : kChoices<Field>) {
      if (text != ToString(choice)) continue;
      *field = choice;
      return true;
    }
    return false;
  } else {
    Field value{};
    if (!ReadScalar(text, &value)) return false;
    *field = value;
    return true;
  }
}

template <class Field>
std::string Format(const Field& field) {
  if constexpr (Enum<Field>) {
    return ToString(field);
  } else if constexpr (std::is_same_v<Field, bool>) {
    return field ? "true" : "false";
  } else if constexpr (std::is_integral_v<Field>) {
    return std::to_string(field);
  } else {
    return FormatOption(static_cast<double>(field));
  }
}

// Returns a text such as "[px] > 0"; empty if any value is valid.
template <class Field>
std::string Describe(const OptionRange& range) {
  if constexpr (Enum<Field>) {
    return fmt::format("{}", fmt::join(Words<Field>(), ", "));
  } else if constexpr (RangedOption<Field>) {
    return (range.unit.empty() ? "" : "[" + std::string(range.unit) + "] ") + range.ToString();
  } else {
    return "";
  }
}

// Calls visit(path, field, range) for every setting.
template <class Options, class Visit>
void ForEachSetting(Options& options, const Visit& visit, const std::string& group = "") {
  ForEachOption(options, [&](const char* name, auto& field, const OptionRange& range = {}) {
    if constexpr (Group<std::remove_cvref_t<decltype(field)>>) {
      ForEachSetting(field, visit, group + name + ".");
    } else {
      visit(group + name, field, range);
    }
  });
}

// Also compares the part after each dot: "max_sigma" matches "tracker.degeneracy.max_sigma".
std::string WhichIsMeant(const std::string& path) {
  std::vector<std::string> known;
  const SlamOptions options;
  ForEachSetting(options, [&](const std::string& name, const auto&, const OptionRange&) {
    known.push_back(name);
  });
  const auto within = std::ranges::find_if(
      known, [&](const std::string& name) { return name.ends_with("." + path); });
  return within == known.end() ? DidYouMean(path, known) : DidYouMean(*within, known);
}

template <class Field>
void ReadField(YamlReader& section, const std::string& key, Field* field) {
  section.Read(key, Demand<Field>(), [&](const std::string& text) { return Parse(text, field); });
}

template <class Options>
void ReadGroup(YamlReader& file, Options* options) {
  ForEachOption(*options, [&](const char* name, auto& field, const OptionRange& = {}) {
    if constexpr (Group<std::remove_cvref_t<decltype(field)>>) {
      ReadGroup(file.Section(name), &field);
    } else {
      ReadField(file, name, &field);
    }
  });
}

template <class Options>
void WriteGroup(const Options& options, const std::string& indent, std::string* file) {
  ForEachOption(options, [&](const char* name, const auto& field, const OptionRange& range = {}) {
    using Field = std::remove_cvref_t<decltype(field)>;
    if constexpr (Group<Field>) {
      *file += indent + name + ":\n";
      WriteGroup(field, indent + "  ", file);
    } else {
      const std::string about = Describe<Field>(range);
      *file += indent + name + ": " + Format(field) + (about.empty() ? "" : "  # " + about) + "\n";
    }
  });
}

}  // namespace

void Set(const std::string& setting, SlamOptions* options) {
  const std::size_t end = setting.find('=');
  const std::string path = CurrentPath(setting.substr(0, end));
  HIGHWALL_REQUIRE(end != std::string::npos,
                   "must be NAME=VALUE, such as tracker.min_support=25, is " + setting);
  const std::string text = setting.substr(end + 1);
  RefuseFormer(path);
  bool found = false;
  ForEachSetting(*options, [&](const std::string& name, auto& field, const OptionRange&) {
    if (name != path) return;
    found = true;
    using Field = std::remove_cvref_t<decltype(field)>;
    HIGHWALL_REQUIRE(Parse(text, &field), path + " must be " + Demand<Field>() + ", is " + text);
  });
  HIGHWALL_REQUIRE(found, "there is no setting " + path + WhichIsMeant(path));
}

void ReadSettings(const std::filesystem::path& path, SlamOptions* options) {
  YamlReader file = YamlReader::Load(path);
  ReadFormerSettings(
      file, [&](YamlReader& section, const std::string& key, const std::string& now) {
        ForEachSetting(*options, [&](const std::string& name, auto& field, const OptionRange&) {
          if (name == now) ReadField(section, key, &field);
        });
      });
  ReadGroup(file, options);
  file.Finish();
  try {
    CheckSettings(*options);
  } catch (const InvalidArgument& error) {
    throw IoError(path, error.what());
  }
}

void CheckSettings(const SlamOptions& options) {
  ForEachSetting(options, [](const std::string& path, const auto& field, const OptionRange& range) {
    using Field = std::remove_cvref_t<decltype(field)>;
    if constexpr (RangedOption<Field>) {
      HIGHWALL_REQUIRE(range.Contains(static_cast<double>(field)),
                       path + " must be " + range.ToString() + ", is " + Format(field));
    }
  });
  HIGHWALL_REQUIRE(options.frame.use_points || options.frame.use_lines,
                   "frame.use_points and frame.use_lines are both false");
}

std::string SettingsFile(const SlamOptions& options) {
  std::string file =
      "# Settings of highwall slam, for --settings FILE: a setting that is left out keeps its "
      "default.\n";
  WriteGroup(options, "", &file);
  return file;
}

std::map<std::string, std::string> ChangedSettings(const SlamOptions& options) {
  std::map<std::string, std::string> defaults, changed;
  const auto gather = [](const SlamOptions& from, std::map<std::string, std::string>* values) {
    ForEachSetting(from, [&](const std::string& path, const auto& field, const OptionRange&) {
      values->emplace(path, Format(field));
    });
  };
  gather(SlamOptions(), &defaults);
  gather(options, &changed);
  std::erase_if(changed,
                [&](const auto& entry) { return defaults.at(entry.first) == entry.second; });
  return changed;
}

}  // namespace highwall::apps
