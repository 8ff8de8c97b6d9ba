// Every field of SlamOptions, and of the options of public functions: a value outside of its range
// is refused by name, by SlamOptions and by the component that uses it, so that none is missed on
// the way; and Deterministic() changes only the threads. (shared_options_test.cc shows that shared
// options reach every stage.)
#include <highwall/frontend/inertial/inertial_odometry.h>
#include <highwall/frontend/local/bundle_adjustment.h>
#include <highwall/frontend/local/option_table.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/system/option_table.h>
#include <highwall/frontend/tracking/standard_keyframe_policy.h>

#include <cxxabi.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <regex>
#include <set>
#include <span>
#include <string>
#include <type_traits>
#include <typeinfo>
#include <vector>

#include <gtest/gtest.h>

#include "calibration/depth_distortion_estimator.h"
#include "features/frame_builder.h"
#include "local/local_mapper.h"
#include "loops/factor_adjuster.h"
#include "loops/loop_closer.h"
#include "support/message_of.h"
#include "support/test_paths.h"
#include "tracking/frame_refiner.h"
#include "tracking/tracker.h"

namespace highwall::slam_options_test {
namespace {

// Calls visit(path, field) for all fields that are not structs, such as "tracker.min_support".
template <class Options, class Visit>
void VisitLeaves(Options& options, const Visit& visit, const std::string& path = "") {
  ForEachOption(options, [&](const char* name, auto& field, const OptionRange& = {}) {
    if constexpr (std::is_class_v<std::remove_cvref_t<decltype(field)>>) {
      VisitLeaves(field, visit, path + name + ".");
    } else {
      visit(path + name, field);
    }
  });
}

// The fields of the structs as their headers declare them, in that order.
using Fields = std::map<std::string, std::vector<std::string>>;
Fields FieldsInHeaders() {
  static const std::regex kStruct("struct (\\w+) \\{");
  static const std::regex kField("  [\\w:]+ (\\w+)( = .*|\\{.*|;.*)");
  Fields fields;
  for (const char* module : {"/factors/include", "/frontend/include"}) {
    for (const auto& file : std::filesystem::recursive_directory_iterator(
             std::string(testing::kSourceFolder) + module)) {
      std::ifstream lines(file.path());
      std::string name;
      std::smatch match;
      for (std::string line; std::getline(lines, line);) {
        if (std::regex_match(line, match, kStruct)) name = match[1];
        if (line == "};") name.clear();
        if (!name.empty() && std::regex_match(line, match, kField)) {
          fields[name].push_back(match[1]);
        }
      }
    }
  }
  return fields;
}

std::string NameOfType(const std::type_info& type) {
  const std::unique_ptr<char, decltype(&std::free)> name(
      abi::__cxa_demangle(type.name(), nullptr, nullptr, nullptr), &std::free);
  return std::string(name.get()).substr(std::string("highwall::").size());
}

// Adds the table's fields of this struct and of those within it, and checks their order in memory.
template <class Options>
void AddFieldsInTable(const Options& options, Fields* fields) {
  std::vector<std::string>& names = (*fields)[NameOfType(typeid(Options))];
  const void* last = nullptr;
  names.clear();
  std::vector<std::function<void()>> groups;
  ForEachOption(options, [&](const char* name, const auto& field, const OptionRange& = {}) {
    names.push_back(name);
    EXPECT_LT(last, static_cast<const void*>(&field)) << name;
    last = &field;
    if constexpr (std::is_class_v<std::remove_cvref_t<decltype(field)>>) {
      groups.push_back([&field, fields] { AddFieldsInTable(field, fields); });
    }
  });
  for (const auto& group : groups) group();
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Values just outside the range of a field, in the order of the fields.
struct Edge {
  const char* field;
  std::vector<double> outside;
};
const Edge kEdges[] = {
    {"frame.orb.features", {0}},
    {"frame.orb.pyramid.levels", {0, 17}},
    {"frame.orb.pyramid.scale_factor", {1, 2.1}},
    {"frame.orb.fast_threshold", {0, 256}},
    {"frame.orb.min_fast_threshold", {0, 21}},
    {"frame.sift.features", {0}},
    {"frame.sift.contrast_threshold", {0}},
    {"frame.lines.min_length", {0, 1.1}},
    {"frame.lines.max_lines", {0}},
    {"measurement.baseline", {0}},
    {"measurement.point_sigma", {0}},
    {"measurement.line_sigma", {-1}},
    {"measurement.motion_radius", {0}},
    {"measurement.max_hamming.projection", {-1, 257}},
    {"measurement.max_hamming.relocalization", {-1, 257}},
    {"measurement.max_hamming.triangulation", {-1, 257}},
    {"tracker.moving.max_share", {0, 1.1}},
    {"tracker.degeneracy.max_sigma", {0}},
    {"tracker.min_support", {1, 5}},
    {"tracker.doubtful_share", {-0.1, 1.1}},
    {"tracker.local_keyframes", {0}},
    {"keyframes.min_features", {5}},
    {"keyframes.min_share", {0, 1.1}},
    {"keyframes.max_gap", {0}},
    {"keyframes.wanted_tracked", {-1}},
    {"keyframes.wanted_new", {-1}},
    {"refinement.waiting", {0}},
    {"mapper.adjusted_keyframes", {1}},
    {"mapper.fixed_keyframes", {0}},
    {"mapper.fused_keyframes", {-1}},
    {"mapper.min_observations", {0}},
    {"inertial.weighting.fixed_weight", {0}},
    {"inertial.extrinsics_position_sigma", {0}},
    {"inertial.extrinsics_rotation_sigma", {0}},
    {"inertial.initializer.gyroscope_bias_sigma", {0}},
    {"inertial.initializer.accelerometer_bias_sigma", {0}},
    {"inertial.initializer.time_offset_sigma", {-1}},
    {"inertial.max_attempts", {0}},
    {"inertial.buffer.max_step", {0}},
    {"inertial.buffer.horizon", {0.1}},
    {"inertial.window_states", {1}},
    {"inertial.tight.interval", {0}},
    {"inertial.tight.max_points", {-1}},
    {"inertial.tight.max_lines", {-1}},
    {"inertial.visual_noise.position", {0}},
    {"inertial.visual_noise.rotation", {0}},
    {"inertial.visual_noise.scale", {0, -1}},
    {"inertial.visual_noise.min_error", {0}},
    {"inertial.max_dead_reckoning", {0}},
    {"loops.graph.drift_translation", {0}},
    {"loops.graph.drift_rotation", {0}},
    {"loops.graph.drift_bias", {-1}},
    {"loops.graph.loop_translation", {0}},
    {"loops.graph.loop_rotation", {0}},
    {"loops.graph.max_loop_chi2", {0}},
    {"loops.graph.min_shared", {0}},
    {"loops.graph.neighbours", {-1}},
    {"loops.detector.consistency", {0}},
    {"loops.detector.min_support", {5}},
    {"loops.detector.min_found", {-0.1, 1.1}},
    {"loops.detector.min_match_ratio_across_submaps", {-0.1, 1.1}},
    {"loops.detector.decisive_ratio", {0.9}},
    {"factors.every", {0}},
    {"factors.share", {-0.1}},
    {"factors.max_angle", {0}},
    {"factors.max_gap", {0}},
    {"submaps.lost_timeout", {-0.1}},
    {"threads", {-1, 257}},
};

// Options of public functions that are no options of SlamSystem.
struct Toolbox {
  BundleAdjustmentOptions bundle{};
  PoseSolverOptions pose{};
  MatchingOptions matching{};
};

void ForEachOption(OptionsOf<Toolbox> auto& options, const auto& visit) {
  visit("bundle", options.bundle);
  visit("pose", options.pose);
  visit("matching", options.matching);
}

const Edge kToolboxEdges[] = {
    {"bundle.point_huber", {0}},
    {"bundle.line_huber", {-1}},
    {"bundle.inliers.chi2_1", {0}},
    {"bundle.inliers.chi2_2", {0}},
    {"bundle.inliers.chi2_3", {0}},
    {"bundle.inliers.chi2_4", {0}},
    {"bundle.first_iterations", {0}},
    {"bundle.second_iterations", {0}},
    {"bundle.tolerance", {-1e-6}},
    {"bundle.trust_region", {0, kInfinity}},
    {"pose.point_huber", {0}},
    {"pose.line_huber", {0}},
    {"pose.plane_huber", {0}},
    {"pose.inliers.chi2_1", {0}},
    {"pose.inliers.chi2_2", {0}},
    {"pose.inliers.chi2_3", {0}},
    {"pose.inliers.chi2_4", {0}},
    {"pose.rounds", {0}},
    {"pose.max_iterations", {0}},
    {"pose.min_support", {2}},
    {"matching.map_radius", {0}},
    {"matching.min_view_cosine", {-1.1, 1.1}},
    {"matching.min_line_pixels", {0.5}},
    {"matching.motion_ratio", {0, 1.1}},
    {"matching.map_ratio", {0, 1.1}},
    {"matching.max_angle_diff", {0}},
    {"matching.lines.small_motion.max_angle", {0, 1.6}},
    {"matching.lines.small_motion.min_length_ratio", {-0.1, 1}},
    {"matching.lines.small_motion.max_midpoint_distance", {0}},
    {"matching.lines.large_motion.max_angle", {0, 1.6}},
    {"matching.lines.large_motion.min_length_ratio", {-0.1, 1}},
    {"matching.lines.large_motion.max_midpoint_distance", {0}},
    {"matching.lines.max_distance", {-1, 257}},
    {"matching.lines.ratio", {0, 1.1}},
    {"matching.lines.mad_k", {0}},
    {"matching.lines.min_deviation", {-0.1}},
};

// Calls a function with its part of the options.
void Use(const std::string& part, const Toolbox& options) {
  const MeasurementModel model(RgbdSensor(), {});
  Map map;
  if (part == "bundle") AdjustBundle(map, model, {}, {}, options.bundle);
  if (part == "pose") options.pose.Validate();
  if (part == "matching") MeasurementModel(RgbdSensor(), {}, Pose(), {}, options.matching);
}

// Creates a component of SlamSystem with its part of the options.
void Use(const std::string& part, const SlamOptions& options) {
  const RgbdSensor sensor;
  if (part == "frame") FrameBuilder(sensor, options.frame);
  const MeasurementModel model(sensor, options.measurement, Pose(), options.frame.orb.pyramid);
  const SensorModel sensor_model(model, {});
  if (part == "tracker") Tracker(model, options.tracker, sensor_model);
  if (part == "keyframes") StandardKeyFramePolicy policy(options.keyframes);
  if (part == "refinement") {
    FrameRefiner(model, sensor.camera, options.refinement, options.tracker);
  }
  if (part == "mapper") LocalMapper(model, options.mapper);
  if (part == "inertial") InertialOdometry({}, options.inertial);
  if (part == "loops") LoopCloser(model, options.loops);
  if (part == "factors") FactorAdjuster(model, options.factors, options.loops.graph);
  if (part == "depth_pattern") {
    DepthDistortionEstimator(sensor.camera, options.depth_pattern, {});
  }
  if (part == "submaps") options.submaps.Validate();
  if (part == "threads") options.Validate();
}

// Sets a value outside any range; returns false for a field without one: a switch, a choice, a
// seed.
template <class Field>
bool Spoil(Field& field) {
  if constexpr (std::is_floating_point_v<Field>) {
    field = std::numeric_limits<Field>::quiet_NaN();
    return true;
  } else if constexpr (std::is_same_v<Field, int>) {
    field = std::numeric_limits<int>::min();
    return true;
  } else {
    static_assert(std::is_same_v<Field, bool> || std::is_enum_v<Field> ||
                  std::is_same_v<Field, std::uint32_t>);
    return false;
  }
}

template <class Field>
void Change(Field& field) {
  if constexpr (std::is_same_v<Field, bool>) {
    field = !field;
  } else {
    field = static_cast<Field>(static_cast<double>(field) + 1.0);
  }
}

std::vector<double> Values(SlamOptions options) {
  std::vector<double> values;
  VisitLeaves(options, [&](const std::string&, const auto& field) {
    values.push_back(static_cast<double>(field));
  });
  return values;
}

std::vector<std::string> Paths() {
  SlamOptions options;
  std::vector<std::string> paths;
  VisitLeaves(options, [&](const std::string& path, const auto&) { paths.push_back(path); });
  return paths;
}

// The order of the addresses shows that each name belongs to its field, and that none is missing.
TEST(SlamOptions, TheTableHasTheFieldsOfEveryStructInTheirOrder) {
  Fields in_table;
  AddFieldsInTable(SlamOptions(), &in_table);
  EXPECT_EQ(in_table.size(), 29u);
  AddFieldsInTable(BundleAdjustmentOptions(), &in_table);
  AddFieldsInTable(PoseSolverOptions(), &in_table);
  AddFieldsInTable(MatchingOptions(), &in_table);
  const Fields in_headers = FieldsInHeaders();
  for (const auto& [name, fields] : in_table) {
    ASSERT_EQ(in_headers.count(name), 1u) << name;
    EXPECT_EQ(fields, in_headers.at(name)) << name;
  }
}

// Expects that the part of the options that has a field refuses values outside of its range.
template <class Options>
void ExpectRefused(std::span<const Edge> edges) {
  const auto expect_refused = [](const std::string& target, const auto& set) {
    Options options;
    VisitLeaves(options, [&](const std::string& path, auto& field) {
      if (path == target) set(field);
    });
    const std::string name = "::" + target.substr(target.rfind('.') + 1);
    if constexpr (std::is_same_v<Options, SlamOptions>) {
      testing::ExpectError(name, [&] { SlamSystem({}, options); });
    }
    const std::string part = target.substr(0, target.find('.'));
    testing::ExpectError(name, [&] { Use(part, options); });
  };
  for (const Edge& edge : edges) {
    SCOPED_TRACE(edge.field);
    for (const double value : edge.outside) {
      expect_refused(edge.field, [&](auto& field) {
        field = static_cast<std::decay_t<decltype(field)>>(value);
      });
    }
    expect_refused(edge.field, [](auto& field) { Spoil(field); });
  }
}

// Expects that the fields that have a range are those of the edges, in this order.
template <class Options>
void ExpectComplete(std::span<const Edge> edges) {
  Options options;
  std::vector<std::string> ranged, known;
  VisitLeaves(options, [&](const std::string& path, auto& field) {
    if (Spoil(field)) ranged.push_back(path);
  });
  for (const Edge& edge : edges) known.push_back(edge.field);
  EXPECT_EQ(known, ranged);
}

TEST(SlamOptions, EachIsRefusedByNameWhereverItGoes) {
  EXPECT_NO_THROW(SlamOptions().Validate());
  ExpectRefused<SlamOptions>(kEdges);
}

TEST(SlamOptions, NoneThatHasARangeIsMissing) {
  ExpectComplete<SlamOptions>(kEdges);
}

TEST(ToolboxOptions, EachIsRefusedByNameAndNoneIsMissing) {
  ExpectRefused<Toolbox>(kToolboxEdges);
  ExpectComplete<Toolbox>(kToolboxEdges);
}

TEST(SlamOptions, DeterministicChangesThreadsAlone) {
  SlamOptions changed;
  VisitLeaves(changed, [](const std::string&, auto& field) { Change(field); });
  const std::vector<std::string> paths = Paths();
  const std::vector<double> before = Values(changed), after = Values(Deterministic(changed));
  std::set<std::string> others;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (after[i] != before[i]) others.insert(paths[i]);
  }
  EXPECT_EQ(others, std::set<std::string>{"threads"});
}

}  // namespace
}  // namespace highwall::slam_options_test
