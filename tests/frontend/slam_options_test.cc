// Every field of SlamOptions: each that has a range is refused outside of it by its name, by
// SlamOptions and by the component that takes it, so that none is overlooked on the way down; and
// Deterministic() leaves all but the threads as they are. (That what stages share reaches each of
// them is shown by shared_options_test.cc.)
#include <highwall/frontend/system/slam_system.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>
#include <highwall/frontend/map/measurement_model.h>

#include "features/frame_builder.h"
#include "inertial/inertial_odometry.h"
#include "local/local_mapper.h"
#include "loops/loop_closer.h"
#include "support/message_of.h"
#include "tracking/keyframe_policy.h"
#include "tracking/tracker.h"

namespace highwall {
namespace {

// Takes the first name off a list "a, b, c".
std::string TakeName(std::string_view& names) {
  const std::string name(names.substr(0, names.find(',')));
  names.remove_prefix(std::min(names.size(), name.size() + 2));
  return name;
}

// The fields of a struct, by name and in their order: one that is not listed does not compile.
#define FIELDS(Struct, ...)                                                            \
  template <class Visit>                                                               \
  void VisitFields(Struct& options, const Visit& visit) {                              \
    auto& [__VA_ARGS__] = options;                                                     \
    std::string_view names = #__VA_ARGS__;                                             \
    const auto each = [&](auto&... fields) { (visit(TakeName(names), fields), ...); }; \
    each(__VA_ARGS__);                                                                 \
  }
// clang-format off
FIELDS(PyramidOptions, levels, scale_factor)
FIELDS(OrbExtractorOptions, features, pyramid, fast_threshold, min_fast_threshold, subpixel)
FIELDS(LineExtractorOptions, detector, min_length, max_lines, merge, refine, descriptors)
FIELDS(SegmentDepthOptions, samples, min_valid, min_inliers, ransac_iterations, seed)
FIELDS(FrameBuilderOptions, orb, lines, segment_depth, use_points, use_lines, depth_spread_share, parallel)
FIELDS(ProjectionMatchOptions, max_hamming, ratio, max_angle_diff)
FIELDS(MapMatcherOptions, motion_radius, map_radius, min_view_cosine, motion_match, map_match, min_line_pixels)
FIELDS(LineGates, max_angle, min_length_ratio, max_midpoint_distance)
FIELDS(LineMatcherOptions, small_motion, large_motion, max_distance, ratio, mad_rule, mad_k, min_deviation)
FIELDS(MeasurementOptions, weighting, baseline, point_sigma, line_sigma, search, line_matches)
FIELDS(InlierBounds, chi2_1, chi2_2, chi2_3, chi2_4)
FIELDS(PoseSolverOptions, point_huber, line_huber, plane_huber, inliers, rounds, max_iterations, min_support)
FIELDS(RelocalizerOptions, candidates, max_hamming, ratio, min_matches, min_inliers, min_line_inliers, ransac_iterations, seed)
FIELDS(LandmarkMotionOptions, min_points, min_share, chi2, min_support, outnumber)
FIELDS(MovingObjectOptions, enabled, settled, max_share, interval, history, min_surface, max_surface, landmarks)
FIELDS(DegeneracyOptions, max_sigma)
FIELDS(SurfaceMatcherOptions, stride, radius, min_share, max_incidence, max_tilt, gate_sigmas, gate)
FIELDS(SurfaceTrackingOptions, enabled, matcher, min_support, min_rows, max_sigma)
FIELDS(DirectAlignmentOptions, enabled, min_rows, min_correlation, max_sigma)
FIELDS(TrackerOptions, timing, pose, relocalizer, moving, degeneracy, surfaces, direct, min_motion_support, min_support, min_predicted_support, doubtful_agreement, doubtful_share, doubtful_drop, local_keyframes, recognized_found, recognized_contradiction)
FIELDS(KeyFramePolicyOptions, min_features, min_share, max_gap, wanted_tracked, wanted_new)
FIELDS(BundleAdjustmentOptions, point_huber, line_huber, inliers, first_iterations, second_iterations, tolerance, trust_region, threads)
FIELDS(TriangulationOptions, keyframes, min_views, scarce_points, max_depth_sigma, max_hamming, ratio)
FIELDS(LocalMapperOptions, bundle, adjusted_keyframes, fixed_keyframes, fused_keyframes, min_found_ratio, probation_keyframes, min_observations, redundant_share, redundant_observers, max_motion_gap, motion_span, max_depth_sigma, min_line_length, triangulation, background, wait)
FIELDS(ImuWeightingOptions, policy, fixed_weight)
FIELDS(InertialInitializerOptions, interval, min_duration, max_duration, gyroscope_bias_sigma, accelerometer_bias_sigma, time_offset_sigma, max_gravity_sigma, max_error, max_gravity_error)
FIELDS(ImuBufferOptions, max_step, horizon)
FIELDS(VisualNoise, position, rotation, scale, min_error)
FIELDS(InertialOptions, weighting, estimate_time_offset, initializer, max_attempts, buffer, window_states, visual_noise, max_dead_reckoning)
FIELDS(KeyFrameGraphOptions, drift_translation, drift_rotation, step_translation, step_rotation, drift_bias, loop_translation, loop_rotation, max_loop_chi2, min_shared, neighbours, hold_gravity)
FIELDS(LoopDetectorOptions, candidates, consistency, min_support, min_found, min_found_apart, overwhelming)
FIELDS(LoopCorrectionOptions, robust, fused_keyframes, threads)
FIELDS(LoopCloserOptions, enabled, graph, detector, correction, adjust, bundle, background)
FIELDS(SubmapOptions, enabled, patience)
FIELDS(SlamOptions, frame, measurement, tracker, keyframes, mapper, inertial, loops, submaps, localize_only)
// clang-format on
#undef FIELDS

// visit(path, field) of those that are no structs themselves, such as "tracker.pose.rounds".
template <class Options, class Visit>
void VisitLeaves(Options& options, const Visit& visit, const std::string& path = "") {
  VisitFields(options, [&](const std::string& name, auto& field) {
    using Field = std::remove_reference_t<decltype(field)>;
    if constexpr (std::is_class_v<Field>) {
      VisitLeaves(field, visit, path + name + ".");
    } else {
      visit(path + name, field);
    }
  });
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Values just beyond the range of a field, in the order of the fields.
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
    {"frame.lines.min_length", {0, 1.1}},
    {"frame.lines.max_lines", {0}},
    {"frame.segment_depth.samples", {3, 65}},
    {"frame.segment_depth.min_valid", {0, 1.1}},
    {"frame.segment_depth.min_inliers", {1.1}},
    {"frame.segment_depth.ransac_iterations", {0}},
    {"frame.depth_spread_share", {-0.1}},
    {"measurement.baseline", {0}},
    {"measurement.point_sigma", {0}},
    {"measurement.line_sigma", {-1}},
    {"measurement.search.motion_radius", {0}},
    {"measurement.search.map_radius", {0}},
    {"measurement.search.min_view_cosine", {-1.1, 1.1}},
    {"measurement.search.motion_match.max_hamming", {-1, 257}},
    {"measurement.search.motion_match.ratio", {0, 1.1}},
    {"measurement.search.motion_match.max_angle_diff", {0}},
    {"measurement.search.map_match.max_hamming", {-1, 257}},
    {"measurement.search.map_match.ratio", {0, 1.1}},
    {"measurement.search.map_match.max_angle_diff", {0}},
    {"measurement.search.min_line_pixels", {0.5}},
    {"measurement.line_matches.small_motion.max_angle", {0, 1.6}},
    {"measurement.line_matches.small_motion.min_length_ratio", {-0.1, 1}},
    {"measurement.line_matches.small_motion.max_midpoint_distance", {0}},
    {"measurement.line_matches.large_motion.max_angle", {0, 1.6}},
    {"measurement.line_matches.large_motion.min_length_ratio", {-0.1, 1}},
    {"measurement.line_matches.large_motion.max_midpoint_distance", {0}},
    {"measurement.line_matches.max_distance", {-1, 257}},
    {"measurement.line_matches.ratio", {0, 1.1}},
    {"measurement.line_matches.mad_k", {0}},
    {"measurement.line_matches.min_deviation", {-0.1}},
    {"tracker.pose.point_huber", {0}},
    {"tracker.pose.line_huber", {0}},
    {"tracker.pose.plane_huber", {0}},
    {"tracker.pose.inliers.chi2_1", {0}},
    {"tracker.pose.inliers.chi2_2", {0}},
    {"tracker.pose.inliers.chi2_3", {0}},
    {"tracker.pose.inliers.chi2_4", {0}},
    {"tracker.pose.rounds", {0}},
    {"tracker.pose.max_iterations", {0}},
    {"tracker.pose.min_support", {2}},
    {"tracker.relocalizer.candidates", {0}},
    {"tracker.relocalizer.max_hamming", {-1, 257}},
    {"tracker.relocalizer.ratio", {0, 1.1}},
    {"tracker.relocalizer.min_matches", {2}},
    {"tracker.relocalizer.min_inliers", {5}},
    {"tracker.relocalizer.min_line_inliers", {3}},
    {"tracker.relocalizer.ransac_iterations", {0}},
    {"tracker.moving.settled", {0}},
    {"tracker.moving.max_share", {0, 1.1}},
    {"tracker.moving.interval", {0}},
    {"tracker.moving.history", {0.1}},
    {"tracker.moving.min_surface", {0}},
    {"tracker.moving.max_surface", {0, 1.1}},
    {"tracker.moving.landmarks.min_points", {0}},
    {"tracker.moving.landmarks.min_share", {0, 1.1}},
    {"tracker.moving.landmarks.chi2", {0}},
    {"tracker.moving.landmarks.min_support", {5}},
    {"tracker.moving.landmarks.outnumber", {0}},
    {"tracker.degeneracy.max_sigma", {0}},
    {"tracker.surfaces.matcher.stride", {0}},
    {"tracker.surfaces.matcher.radius", {0}},
    {"tracker.surfaces.matcher.min_share", {0, 1.1}},
    {"tracker.surfaces.matcher.max_incidence", {0, 1.6}},
    {"tracker.surfaces.matcher.max_tilt", {0}},
    {"tracker.surfaces.matcher.gate_sigmas", {0}},
    {"tracker.surfaces.matcher.gate", {-0.1}},
    {"tracker.surfaces.min_support", {2}},
    {"tracker.surfaces.min_rows", {0}},
    {"tracker.surfaces.max_sigma", {0}},
    {"tracker.direct.min_rows", {0}},
    {"tracker.direct.min_correlation", {-0.1, 1}},
    {"tracker.direct.max_sigma", {0}},
    {"tracker.min_motion_support", {5}},
    {"tracker.min_support", {1, 5}},
    {"tracker.min_predicted_support", {5}},
    {"tracker.doubtful_agreement", {-0.1, 1.1}},
    {"tracker.doubtful_share", {-0.1, 1.1}},
    {"tracker.doubtful_drop", {-0.1, 1.1}},
    {"tracker.local_keyframes", {0}},
    {"tracker.recognized_found", {-0.1, 1.1}},
    {"tracker.recognized_contradiction", {-0.1, 1.1}},
    {"keyframes.min_features", {5}},
    {"keyframes.min_share", {0, 1.1}},
    {"keyframes.max_gap", {0}},
    {"keyframes.wanted_tracked", {-1}},
    {"keyframes.wanted_new", {-1}},
    {"mapper.bundle.point_huber", {0}},
    {"mapper.bundle.line_huber", {-1}},
    {"mapper.bundle.inliers.chi2_1", {0}},
    {"mapper.bundle.inliers.chi2_2", {0}},
    {"mapper.bundle.inliers.chi2_3", {0}},
    {"mapper.bundle.inliers.chi2_4", {0}},
    {"mapper.bundle.first_iterations", {0}},
    {"mapper.bundle.second_iterations", {0}},
    {"mapper.bundle.tolerance", {-1e-6}},
    {"mapper.bundle.trust_region", {0, kInfinity}},
    {"mapper.bundle.threads", {0}},
    {"mapper.adjusted_keyframes", {1}},
    {"mapper.fixed_keyframes", {0}},
    {"mapper.fused_keyframes", {-1}},
    {"mapper.min_found_ratio", {-0.1, 1.5}},
    {"mapper.probation_keyframes", {0}},
    {"mapper.min_observations", {0}},
    {"mapper.redundant_share", {0, 1.1}},
    {"mapper.redundant_observers", {0}},
    {"mapper.max_motion_gap", {0}},
    {"mapper.motion_span", {-1}},
    {"mapper.max_depth_sigma", {0}},
    {"mapper.min_line_length", {0}},
    {"mapper.triangulation.keyframes", {-1}},
    {"mapper.triangulation.min_views", {1}},
    {"mapper.triangulation.scarce_points", {-1}},
    {"mapper.triangulation.max_depth_sigma", {0}},
    {"mapper.triangulation.max_hamming", {-1, 257}},
    {"mapper.triangulation.ratio", {0, 1.1}},
    {"inertial.weighting.fixed_weight", {0}},
    {"inertial.initializer.interval", {0}},
    {"inertial.initializer.min_duration", {0}},
    {"inertial.initializer.max_duration", {1}},
    {"inertial.initializer.gyroscope_bias_sigma", {0}},
    {"inertial.initializer.accelerometer_bias_sigma", {0}},
    {"inertial.initializer.time_offset_sigma", {-1}},
    {"inertial.initializer.max_gravity_sigma", {0}},
    {"inertial.initializer.max_error", {0}},
    {"inertial.initializer.max_gravity_error", {0, 1}},
    {"inertial.max_attempts", {0}},
    {"inertial.buffer.max_step", {0}},
    {"inertial.buffer.horizon", {0.1}},
    {"inertial.window_states", {1}},
    {"inertial.visual_noise.position", {0}},
    {"inertial.visual_noise.rotation", {0}},
    {"inertial.visual_noise.scale", {0, -1}},
    {"inertial.visual_noise.min_error", {0}},
    {"inertial.max_dead_reckoning", {0}},
    {"loops.graph.drift_translation", {0}},
    {"loops.graph.drift_rotation", {0}},
    {"loops.graph.step_translation", {0}},
    {"loops.graph.step_rotation", {0}},
    {"loops.graph.drift_bias", {-1}},
    {"loops.graph.loop_translation", {0}},
    {"loops.graph.loop_rotation", {0}},
    {"loops.graph.max_loop_chi2", {0}},
    {"loops.graph.min_shared", {0}},
    {"loops.graph.neighbours", {-1}},
    {"loops.detector.candidates", {0}},
    {"loops.detector.consistency", {0}},
    {"loops.detector.min_support", {5}},
    {"loops.detector.min_found", {-0.1, 1.1}},
    {"loops.detector.min_found_apart", {-0.1, 1.1}},
    {"loops.detector.overwhelming", {0.9}},
    {"loops.correction.fused_keyframes", {-1}},
    {"loops.correction.threads", {0}},
    {"loops.bundle.point_huber", {0}},
    {"loops.bundle.line_huber", {0}},
    {"loops.bundle.inliers.chi2_1", {0}},
    {"loops.bundle.inliers.chi2_2", {0}},
    {"loops.bundle.inliers.chi2_3", {0}},
    {"loops.bundle.inliers.chi2_4", {0}},
    {"loops.bundle.first_iterations", {0}},
    {"loops.bundle.second_iterations", {0}},
    {"loops.bundle.tolerance", {-1e-6}},
    {"loops.bundle.trust_region", {0, kInfinity}},
    {"loops.bundle.threads", {0}},
    {"submaps.patience", {-0.1}},
};

// What SlamSystem is made of, each with its part of the options.
void MakeUserOf(const std::string& part, const SlamOptions& options) {
  const RgbdSensor sensor;
  if (part == "frame") FrameBuilder(sensor, options.frame);
  const MeasurementModel model(sensor, options.measurement, Pose(), options.frame.orb.pyramid);
  if (part == "tracker") Tracker(model, options.tracker);
  if (part == "keyframes") KeyFramePolicy policy(options.keyframes);
  if (part == "mapper") LocalMapper(model, options.mapper);
  if (part == "inertial") InertialOdometry({}, options.inertial);
  if (part == "loops") LoopCloser(model, options.loops);
  if (part == "submaps") options.submaps.Validate();
}

// Beyond any range; false where the field has none: a switch, a choice, a seed.
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

TEST(SlamOptions, EachIsRefusedByNameWhereverItGoes) {
  EXPECT_NO_THROW(SlamOptions().Validate());
  const auto expect_refused = [](const std::string& target, const auto& set) {
    SlamOptions options;
    VisitLeaves(options, [&](const std::string& path, auto& field) {
      if (path == target) set(field);
    });
    const std::string name = "::" + target.substr(target.rfind('.') + 1);
    testing::ExpectError(name, [&] { SlamSystem({}, options); });
    const std::string part = target.substr(0, target.find('.'));
    testing::ExpectError(name, [&] { MakeUserOf(part, options); });
  };
  for (const Edge& edge : kEdges) {
    SCOPED_TRACE(edge.field);
    for (const double value : edge.outside) {
      expect_refused(edge.field, [&](auto& field) {
        field = static_cast<std::decay_t<decltype(field)>>(value);
      });
    }
    expect_refused(edge.field, [](auto& field) { Spoil(field); });
  }
}

TEST(SlamOptions, NoneThatHasARangeIsMissing) {
  SlamOptions options;
  std::vector<std::string> ranged, known;
  VisitLeaves(options, [&](const std::string& path, auto& field) {
    if (Spoil(field)) ranged.push_back(path);
  });
  for (const Edge& edge : kEdges) known.push_back(edge.field);
  EXPECT_EQ(known, ranged);
}

TEST(SlamOptions, DeterministicChangesThreadsAlone) {
  SlamOptions changed;
  VisitLeaves(changed, [](const std::string&, auto& field) { Change(field); });
  changed.frame.parallel = changed.mapper.background = changed.loops.background = true;
  const std::vector<std::string> paths = Paths();
  const std::vector<double> before = Values(changed), after = Values(Deterministic(changed));
  std::set<std::string> others;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (after[i] != before[i]) others.insert(paths[i]);
  }
  EXPECT_EQ(others, (std::set<std::string>{"frame.parallel", "mapper.background",
                                           "mapper.bundle.threads", "loops.background",
                                           "loops.bundle.threads", "loops.correction.threads"}));
}

}  // namespace
}  // namespace highwall
