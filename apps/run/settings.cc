#include "run/settings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <type_traits>
#include <vector>

#include <fmt/format.h>

#include <highwall/core/error.h>
#include <highwall/frontend/system/option_table.h>

#include "cli/did_you_mean.h"
#include "files/yaml_reader.h"

namespace highwall::apps {
namespace {

// Settings that version 0.2 knew by another name, which is accepted as well until version 0.4.
struct Renamed {
  std::string_view before, now;
};
constexpr std::array kRenamed = {
    Renamed{"loops.detector.min_found_apart", "loops.detector.min_match_ratio_across_submaps"},
    Renamed{"loops.detector.overwhelming", "loops.detector.decisive_ratio"},
    Renamed{"submaps.patience", "submaps.lost_timeout"},
};

// Settings of version 0.2 whose place `threads` has taken. Files may hold them until version 0.4,
// with the value that they had by default.
struct Replaced {
  std::string_view path, usual;
};
constexpr std::array kReplacedByThreads = {
    Replaced{"frame.parallel", "true"},
    Replaced{"refinement.background", "true"},
    Replaced{"mapper.bundle.threads", "1"},
    Replaced{"mapper.background", "true"},
    Replaced{"inertial.tight.background", "true"},
    Replaced{"loops.correction.threads", "2"},
    Replaced{"loops.bundle.threads", "2"},
    Replaced{"loops.background", "true"},
    Replaced{"factors.threads", "2"},
    Replaced{"factors.background", "true"},
    Replaced{"depth_pattern.background", "true"},
};
constexpr const char* kThreads = "`threads` is for all stages now, and 0 makes them synchronous";

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

// Also compares the part after each dot: "rounds" matches "tracker.pose.rounds".
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

// Returns the current path of a setting.
std::string CurrentPath(const std::string& path) {
  const auto* renamed = std::ranges::find(kRenamed, path, &Renamed::before);
  return renamed == kRenamed.end() ? path : std::string(renamed->now);
}

template <class Options>
void ReadGroup(YamlReader& file, Options* options, const std::string& group = "") {
  ForEachOption(*options, [&](const char* name, auto& field, const OptionRange& = {}) {
    using Field = std::remove_cvref_t<decltype(field)>;
    if constexpr (Group<Field>) {
      ReadGroup(file.Section(name), &field, group + name + ".");
    } else {
      const auto parse = [&](const std::string& text) { return Parse(text, &field); };
      for (const Renamed& renamed : kRenamed) {
        if (renamed.now != group + name) continue;
        file.Read(std::string(renamed.before.substr(group.size())), Demand<Field>(), parse);
      }
      file.Read(name, Demand<Field>(), parse);
    }
  });
  for (const Replaced& replaced : kReplacedByThreads) {
    const std::size_t name = replaced.path.rfind('.') + 1;
    if (replaced.path.substr(0, name) != group) continue;
    file.Read(std::string(replaced.path.substr(name)), std::string("left out (") + kThreads + ")",
              [&](const std::string& text) {
                bool on = false;
                return text == replaced.usual ||
                       (replaced.usual == "true" && ReadScalar(text, &on) && on);
              });
  }
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
  HIGHWALL_REQUIRE(
      std::ranges::find(kReplacedByThreads, path, &Replaced::path) == kReplacedByThreads.end(),
      "there is no setting " + path + " any more: " + kThreads);
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
