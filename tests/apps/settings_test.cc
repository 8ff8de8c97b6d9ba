// Sets, lists, writes and reads back every option of SlamOptions by its path.
#include "run/settings.h"

#include <filesystem>
#include <string>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>
#include <highwall/core/error.h>
#include <highwall/frontend/system/option_table.h>

#include "support/message_of.h"
#include "support/temporary_directory.h"

namespace highwall::apps::settings_test {
namespace {

using testing::MessageOf;

// Returns a different value within the range.
template <class Field>
void Change(Field* field, const OptionRange& range) {
  if constexpr (std::is_same_v<Field, bool>) {
    *field = !*field;
  } else if constexpr (std::is_enum_v<Field>) {
    *field = *field == kChoices<Field>.front() ? kChoices<Field>.back() : kChoices<Field>.front();
  } else {
    for (const double value : {*field + 1.0, *field - 1.0, 0.9 * *field}) {
      if (!range.Contains(value) || static_cast<Field>(value) == *field) continue;
      *field = static_cast<Field>(value);
      return;
    }
    FAIL();
  }
}

template <class Options>
void ChangeAll(Options* options, int* count) {
  ForEachOption(*options, [&](const char*, auto& field, const OptionRange& range = {}) {
    if constexpr (std::is_class_v<std::remove_cvref_t<decltype(field)>>) {
      ChangeAll(&field, count);
    } else {
      Change(&field, range);
      ++*count;
    }
  });
}

class SettingsTest : public ::testing::Test {
 protected:
  // Returns the options that ReadSettings() reads from a file with this text.
  SlamOptions Read(const std::string& text) {
    testing::WriteText(file_, text);
    SlamOptions options;
    ReadSettings(file_, &options);
    return options;
  }
  std::string Refusal(const std::string& text) {
    return MessageOf<IoError>([&] { Read(text); });
  }
  static std::string RefusalOf(const std::string& setting) {
    return MessageOf<InvalidArgument>([&] {
      SlamOptions options;
      Set(setting, &options);
      CheckSettings(options);
    });
  }

  testing::TemporaryDirectory folder_{"settings"};
  std::filesystem::path file_ = folder_.path() / "settings.yaml";
};

TEST_F(SettingsTest, ReadsBackEverySetting) {
  SlamOptions options;
  EXPECT_EQ(SettingsFile(Read(SettingsFile(options))), SettingsFile(options));
  EXPECT_TRUE(ChangedSettings(options).empty());
  int count = 0;
  ChangeAll(&options, &count);
  options.frame.use_points = true;  // at least one is on
  const SlamOptions read = Read(SettingsFile(options));
  EXPECT_EQ(SettingsFile(read), SettingsFile(options));
  EXPECT_EQ(ChangedSettings(read).size(), static_cast<std::size_t>(count - 1));
}

TEST_F(SettingsTest, EachThatIsWrittenCanBeSetByItsPath) {
  SlamOptions changed, options;
  int count = 0;
  ChangeAll(&changed, &count);
  for (const auto& [path, value] : ChangedSettings(changed)) Set(path + "=" + value, &options);
  EXPECT_EQ(SettingsFile(options), SettingsFile(changed));
}

TEST_F(SettingsTest, TheFileSaysUnitsAndRanges) {
  const std::string file = SettingsFile({});
  for (const char* line :
       {"\n  orb:\n    features: 1000  # >= 1\n", "\n    pyramid:\n      levels: 8  # in [1, 16]\n",
        "\n  point_sigma: 0.7  # [px] > 0\n", "    detector: edlines  # lsd, edlines\n",
        "    min_length: 0.04  # [of the longer image side] in (0, 1]\n",
        "\nlocalize_only: false\n", "  lost_timeout: 0.3  # [s] >= 0\n"}) {
    EXPECT_NE(file.find(line), std::string::npos) << line;
  }
}

TEST_F(SettingsTest, AFileNeedNotSayAll) {
  const SlamOptions options = Read("tracker: {min_support: 31, degeneracy: {max_sigma: 0.04}}\n");
  EXPECT_EQ(options.tracker.min_support, 31);
  EXPECT_EQ(options.tracker.degeneracy.max_sigma, 0.04);
  EXPECT_EQ(ChangedSettings(options).size(), 2u);
}

TEST_F(SettingsTest, NamesOfTheVersionBeforeAreAcceptedAsTheyAre) {
  const SlamOptions read = Read(
      "submaps: {patience: 0.7}\nloops: {detector: {overwhelming: 3, min_found_apart: 0.5}}\n");
  SlamOptions set;
  for (const char* setting : {"submaps.patience=0.7", "loops.detector.overwhelming=3",
                              "loops.detector.min_found_apart=0.5"}) {
    Set(setting, &set);
  }
  EXPECT_EQ(read.submaps.lost_timeout, 0.7);
  EXPECT_EQ(ChangedSettings(read).size(), 3u);
  EXPECT_EQ(SettingsFile(read), SettingsFile(set));
  EXPECT_EQ(SettingsFile({}).find("patience"), std::string::npos) << "written by the new name only";
}

TEST_F(SettingsTest, TwoFormerNamesOfOneSettingMustAgree) {
  const auto both = [&](int motion, int map) {
    return "measurement:\n  search:\n    motion_match: {max_hamming: " + std::to_string(motion) +
           "}\n    map_match: {max_hamming: " + std::to_string(map) + "}\n";
  };
  EXPECT_EQ(Read(both(70, 70)).measurement.max_hamming.projection, 70);
  const std::string message = MessageOf<IoError>([&] { Read(both(120, 100)); });
  EXPECT_NE(message.find(":4: two settings of the file are measurement.max_hamming.projection now"),
            std::string::npos)
      << message;
}

TEST_F(SettingsTest, NamesOfTheVersionBeforeAreAcceptedInOtherGroups) {
  const SlamOptions read = Read(
      "measurement: {search: {motion_radius: 30, motion_match: {max_hamming: 70}},\n"
      "              line_matches: {mad_rule: paper}}\n"
      "tracker: {relocalizer: {max_hamming: 45}}\nmapper: {triangulation: {max_hamming: 35}}\n");
  EXPECT_EQ(read.measurement.motion_radius, 30.0);
  EXPECT_EQ(read.measurement.max_hamming.projection, 70);
  EXPECT_EQ(read.measurement.max_hamming.relocalization, 45);
  EXPECT_EQ(read.measurement.max_hamming.triangulation, 35);
  EXPECT_EQ(read.measurement.mad_rule, MadRule::kPaper);
  SlamOptions set;
  for (const char* setting :
       {"measurement.search.motion_radius=30", "measurement.search.map_match.max_hamming=70",
        "measurement.line_matches.mad_rule=paper", "tracker.relocalizer.max_hamming=45",
        "mapper.triangulation.max_hamming=35"}) {
    Set(setting, &set);
  }
  EXPECT_EQ(SettingsFile(read), SettingsFile(set));
}

TEST_F(SettingsTest, ConstantsThatWereSettingsAreAcceptedWithTheirDefaultsAlone) {
  const SlamOptions read = Read(
      "frame: {segment_depth: {samples: 24}}\n"
      "tracker: {relocalizer: {ratio: 0.80}, pose: {inliers: {chi2_1: 3.841}}, min_support: 31}\n"
      "inertial: {tight: {leaving: oldest_first, map_drift: 0.0006}}\n"
      "loops: {bundle: {tolerance: 0.0001, threads: 2}}\n");
  EXPECT_EQ(read.tracker.min_support, 31);
  EXPECT_EQ(ChangedSettings(read).size(), 1u);
  const std::string gone =
      "there is no setting tracker.relocalizer.ratio any more: it is a constant now";
  EXPECT_EQ(Refusal("tracker:\n  relocalizer:\n    ratio: 0.7\n"), file_.string() + ":3: " + gone);
  EXPECT_EQ(RefusalOf("tracker.relocalizer.ratio=0.7"), gone);
  EXPECT_EQ(Refusal("inertial: {tight: {leaving: least_information}}\n"),
            file_.string() +
                ":1: there is no setting inertial.tight.leaving any more: the oldest state always "
                "leaves");
  EXPECT_EQ(Refusal("tracker:\n  relocalizer:\n    ratoi: 0.7\n"),
            file_.string() + ":3: unknown key 'ratoi'");
}

TEST_F(SettingsTest, ThreadOptionsOfTheVersionBeforeAreAcceptedWithTheirDefaultsAlone) {
  const SlamOptions read = Read(
      "frame: {parallel: true}\nmapper: {background: true, bundle: {threads: 1}}\n"
      "loops: {background: true, bundle: {threads: 2}, correction: {threads: 2}}\n");
  EXPECT_EQ(SettingsFile(read), SettingsFile({}));
  EXPECT_EQ(Refusal("mapper:\n  background: false\n"),
            file_.string() +
                ":2: there is no setting mapper.background any more: `threads` is for all stages "
                "now, and 0 makes them synchronous");
  SlamOptions options;
  EXPECT_EQ(testing::MessageOf<InvalidArgument>([&] { Set("mapper.background=true", &options); }),
            "there is no setting mapper.background any more: `threads` is for all stages now, and "
            "0 makes them synchronous");
}

TEST_F(SettingsTest, AFileIsRefusedByItsLineAndInItsWords) {
  EXPECT_EQ(Refusal("tracker:\n  min_suport: 30\n"),
            file_.string() + ":2: unknown key 'min_suport'; did you mean 'min_support'?");
  EXPECT_EQ(Refusal("tracker:\n  min_support: 3.5\n"),
            file_.string() + ":2: 'min_support' must be an integer, found '3.5'");
  EXPECT_EQ(Refusal("frame:\n  lines:\n    detector: lds\n"),
            file_.string() + ":3: 'detector' must be one of lsd, edlines, found 'lds'");
  EXPECT_EQ(Refusal("tracker:\n  min_support: 3\n"),
            file_.string() + ": tracker.min_support must be >= 6, is 3");
}

TEST_F(SettingsTest, ASettingIsRefusedInItsWords) {
  EXPECT_EQ(RefusalOf("tracker.min_support"),
            "must be NAME=VALUE, such as tracker.min_support=25, is tracker.min_support");
  EXPECT_EQ(RefusalOf("tracker.min_suport=7"),
            "there is no setting tracker.min_suport; did you mean 'tracker.min_support'?");
  EXPECT_EQ(RefusalOf("max_sigma=7"),
            "there is no setting max_sigma; did you mean 'tracker.degeneracy.max_sigma'?");
  EXPECT_EQ(RefusalOf("elephants=7"), "there is no setting elephants");
  EXPECT_EQ(RefusalOf("frame.orb=7"),
            "there is no setting frame.orb; did you mean 'frame.orb.features'?");
  EXPECT_EQ(RefusalOf("tracker.min_support=many"),
            "tracker.min_support must be an integer, is many");
  EXPECT_EQ(RefusalOf("frame.use_lines=2"), "frame.use_lines must be true or false, is 2");
  EXPECT_EQ(RefusalOf("measurement.point_sigma=x"),
            "measurement.point_sigma must be a number, is x");
  EXPECT_EQ(RefusalOf("measurement.point_sigma=.nan"),
            "measurement.point_sigma must be > 0, is nan");
  EXPECT_EQ(RefusalOf("frame.lines.detector=lds"),
            "frame.lines.detector must be one of lsd, edlines, is lds");
  EXPECT_EQ(RefusalOf("frame.orb.pyramid.levels=17"),
            "frame.orb.pyramid.levels must be in [1, 16], is 17");
}

TEST_F(SettingsTest, SomethingMustBeTracked) {
  EXPECT_EQ(MessageOf<InvalidArgument>([] {
              SlamOptions options;
              Set("frame.use_points=false", &options);
              Set("frame.use_lines=false", &options);
              CheckSettings(options);
            }),
            "frame.use_points and frame.use_lines are both false");
}

}  // namespace
}  // namespace highwall::apps::settings_test
