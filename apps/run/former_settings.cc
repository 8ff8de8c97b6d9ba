#include "run/former_settings.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <span>
#include <string_view>

#include <highwall/core/error.h>

namespace highwall::apps {
namespace {

struct Renamed {
  std::string_view before, now;
};
constexpr std::array kRenamed = {
    Renamed{"measurement.search.motion_radius", "measurement.motion_radius"},
    Renamed{"measurement.search.motion_match.max_hamming", "measurement.max_hamming.projection"},
    Renamed{"measurement.search.map_match.max_hamming", "measurement.max_hamming.projection"},
    Renamed{"measurement.line_matches.mad_rule", "measurement.mad_rule"},
    Renamed{"tracker.relocalizer.max_hamming", "measurement.max_hamming.relocalization"},
    Renamed{"mapper.triangulation.max_hamming", "measurement.max_hamming.triangulation"},
    Renamed{"loops.detector.min_found_apart", "loops.detector.min_match_ratio_across_submaps"},
    Renamed{"loops.detector.overwhelming", "loops.detector.decisive_ratio"},
    Renamed{"submaps.patience", "submaps.lost_timeout"},
};

struct Former {
  std::string_view path, usual;  // usual: its default
};
// `threads` has taken their place.
constexpr std::array kReplacedByThreads = {
    Former{"frame.parallel", "true"},
    Former{"refinement.background", "true"},
    Former{"mapper.bundle.threads", "1"},
    Former{"mapper.background", "true"},
    Former{"inertial.tight.background", "true"},
    Former{"loops.correction.threads", "2"},
    Former{"loops.bundle.threads", "2"},
    Former{"loops.background", "true"},
    Former{"factors.threads", "2"},
    Former{"factors.background", "true"},
    Former{"depth_pattern.background", "true"},
};

// Constants now.
constexpr std::array kConstants = {
    Former{"frame.segment_depth.samples", "24"},
    Former{"frame.segment_depth.min_valid", "0.5"},
    Former{"frame.segment_depth.min_inliers", "0.6"},
    Former{"frame.segment_depth.ransac_iterations", "16"},
    Former{"frame.segment_depth.seed", "1"},
    Former{"frame.depth_spread_share", "1"},
    Former{"measurement.search.map_radius", "4"},
    Former{"measurement.search.min_view_cosine", "0.5"},
    Former{"measurement.search.motion_match.ratio", "0.9"},
    Former{"measurement.search.motion_match.max_angle_diff", "30"},
    Former{"measurement.search.map_match.ratio", "0.8"},
    Former{"measurement.search.map_match.max_angle_diff", "30"},
    Former{"measurement.search.min_line_pixels", "15"},
    Former{"measurement.line_matches.small_motion.max_angle", "0.1745"},
    Former{"measurement.line_matches.small_motion.min_length_ratio", "0.5"},
    Former{"measurement.line_matches.small_motion.max_midpoint_distance", "30"},
    Former{"measurement.line_matches.large_motion.max_angle", "0.6"},
    Former{"measurement.line_matches.large_motion.min_length_ratio", "0.3"},
    Former{"measurement.line_matches.large_motion.max_midpoint_distance", "200"},
    Former{"measurement.line_matches.max_distance", "80"},
    Former{"measurement.line_matches.ratio", "0.85"},
    Former{"measurement.line_matches.mad_k", "3"},
    Former{"measurement.line_matches.min_deviation", "0.0087"},
    Former{"tracker.pose.point_huber", "2.4"},
    Former{"tracker.pose.line_huber", "2.4"},
    Former{"tracker.pose.plane_huber", "1.5"},
    Former{"tracker.pose.inliers.chi2_1", "3.841"},
    Former{"tracker.pose.inliers.chi2_2", "5.991"},
    Former{"tracker.pose.inliers.chi2_3", "7.815"},
    Former{"tracker.pose.inliers.chi2_4", "9.488"},
    Former{"tracker.pose.rounds", "3"},
    Former{"tracker.pose.max_iterations", "6"},
    Former{"tracker.pose.min_support", "6"},
    Former{"tracker.relocalizer.candidates", "5"},
    Former{"tracker.relocalizer.ratio", "0.8"},
    Former{"tracker.relocalizer.min_matches", "15"},
    Former{"tracker.relocalizer.min_inliers", "20"},
    Former{"tracker.relocalizer.min_line_inliers", "8"},
    Former{"tracker.relocalizer.ransac_iterations", "200"},
    Former{"tracker.relocalizer.seed", "1"},
    Former{"tracker.moving.settled", "1.5"},
    Former{"tracker.moving.interval", "0.5"},
    Former{"tracker.moving.history", "4"},
    Former{"tracker.moving.min_surface", "40"},
    Former{"tracker.moving.max_surface", "0.5"},
    Former{"tracker.moving.landmarks.min_points", "8"},
    Former{"tracker.moving.landmarks.min_share", "0.7"},
    Former{"tracker.moving.landmarks.chi2", "25.9"},
    Former{"tracker.moving.landmarks.min_support", "20"},
    Former{"tracker.moving.landmarks.outnumber", "1"},
    Former{"tracker.surfaces.matcher.stride", "2"},
    Former{"tracker.surfaces.matcher.radius", "4"},
    Former{"tracker.surfaces.matcher.min_share", "0.7"},
    Former{"tracker.surfaces.matcher.max_incidence", "1.3"},
    Former{"tracker.surfaces.matcher.max_tilt", "0.05"},
    Former{"tracker.surfaces.matcher.gate_sigmas", "4"},
    Former{"tracker.surfaces.matcher.gate", "0.03"},
    Former{"tracker.surfaces.min_support", "6"},
    Former{"tracker.surfaces.min_rows", "30"},
    Former{"tracker.surfaces.max_sigma", "0.2"},
    Former{"tracker.direct.min_rows", "30"},
    Former{"tracker.direct.min_correlation", "0.8"},
    Former{"tracker.direct.max_sigma", "0.05"},
    Former{"tracker.min_motion_support", "15"},
    Former{"tracker.min_predicted_support", "12"},
    Former{"tracker.doubtful_agreement", "0.33"},
    Former{"tracker.doubtful_drop", "0.3"},
    Former{"tracker.recognized_found", "0.5"},
    Former{"tracker.recognized_contradiction", "0.1"},
    Former{"refinement.keyframes", "10"},
    Former{"refinement.rounds", "3"},
    Former{"mapper.bundle.point_huber", "2.8"},
    Former{"mapper.bundle.line_huber", "2.8"},
    Former{"mapper.bundle.inliers.chi2_1", "3.841"},
    Former{"mapper.bundle.inliers.chi2_2", "5.991"},
    Former{"mapper.bundle.inliers.chi2_3", "7.815"},
    Former{"mapper.bundle.inliers.chi2_4", "9.488"},
    Former{"mapper.bundle.first_iterations", "5"},
    Former{"mapper.bundle.second_iterations", "8"},
    Former{"mapper.bundle.tolerance", "1e-6"},
    Former{"mapper.bundle.trust_region", "1e4"},
    Former{"mapper.min_found_ratio", "0.25"},
    Former{"mapper.probation_keyframes", "3"},
    Former{"mapper.redundant_share", "0.9"},
    Former{"mapper.redundant_observers", "2"},
    Former{"mapper.max_motion_gap", "1"},
    Former{"mapper.motion_span", "20"},
    Former{"mapper.max_depth_sigma", "0.03"},
    Former{"mapper.min_line_length", "0.05"},
    Former{"mapper.triangulation.keyframes", "10"},
    Former{"mapper.triangulation.min_views", "3"},
    Former{"mapper.triangulation.scarce_points", "100"},
    Former{"mapper.triangulation.max_depth_sigma", "0.1"},
    Former{"mapper.triangulation.ratio", "0.8"},
    Former{"inertial.initializer.interval", "0.1"},
    Former{"inertial.initializer.min_duration", "1"},
    Former{"inertial.initializer.max_duration", "8"},
    Former{"inertial.initializer.max_gravity_sigma", "0.015"},
    Former{"inertial.initializer.max_error", "20"},
    Former{"inertial.initializer.max_gravity_error", "0.06"},
    Former{"inertial.tight.map_drift", "6e-4"},
    Former{"inertial.tight.map_turn", "2e-4"},
    Former{"loops.graph.step_translation", "0.005"},
    Former{"loops.graph.step_rotation", "0.003"},
    Former{"loops.detector.candidates", "3"},
    Former{"loops.correction.fused_keyframes", "12"},
    Former{"loops.bundle.point_huber", "2.8"},
    Former{"loops.bundle.line_huber", "2.8"},
    Former{"loops.bundle.inliers.chi2_1", "3.841"},
    Former{"loops.bundle.inliers.chi2_2", "5.991"},
    Former{"loops.bundle.inliers.chi2_3", "7.815"},
    Former{"loops.bundle.inliers.chi2_4", "9.488"},
    Former{"loops.bundle.first_iterations", "4"},
    Former{"loops.bundle.second_iterations", "4"},
    Former{"loops.bundle.tolerance", "1e-4"},
    Former{"loops.bundle.trust_region", "1e8"},
    Former{"depth_pattern.first", "12"},
    Former{"depth_pattern.most", "60"},
};

constexpr std::array kLeaving = {
    Former{"inertial.tight.leaving", "oldest_first"},
};

struct GoneSettings {
  std::span<const Former> settings;
  std::string_view reason;
};
constexpr std::array kGone = {
    GoneSettings{kReplacedByThreads,
                 "`threads` is for all stages now, and 0 makes them synchronous"},
    GoneSettings{kConstants, "it is a constant now"},
    GoneSettings{kLeaving, "the oldest state always leaves"},
};

std::string WhyGone(std::string_view path, std::string_view reason) {
  return "there is no setting " + std::string(path) + " any more: " + std::string(reason);
}

template <class T>
bool AreEqual(const std::string& a, const std::string& b) {
  T first{}, second{};
  return ReadScalar(a, &first) && ReadScalar(b, &second) && first == second;
}

bool IsSameValue(const std::string& a, const std::string& b) {
  return a == b || AreEqual<double>(a, b) || AreEqual<bool>(a, b);
}

std::string NameOf(std::string_view path) {
  return std::string(path.substr(path.rfind('.') + 1));
}

// Returns the section of a setting; null if the file does not hold the setting.
YamlReader* SectionOf(YamlReader& file, std::string_view path) {
  YamlReader* section = &file;
  while (section->Has(std::string(path.substr(0, path.find('.'))))) {
    const std::size_t dot = path.find('.');
    if (dot == std::string_view::npos) return section;
    section = &section->Section(std::string(path.substr(0, dot)));
    path.remove_prefix(dot + 1);
  }
  return nullptr;
}

}  // namespace

std::string CurrentPath(const std::string& path) {
  const auto* renamed = std::ranges::find(kRenamed, path, &Renamed::before);
  return renamed == kRenamed.end() ? path : std::string(renamed->now);
}

void RefuseFormer(const std::string& path) {
  for (const GoneSettings& group : kGone) {
    HIGHWALL_REQUIRE(std::ranges::find(group.settings, path, &Former::path) == group.settings.end(),
                     WhyGone(path, group.reason));
  }
}

void ReadFormerSettings(YamlReader& file,
                        const std::function<void(YamlReader& section, const std::string& key,
                                                 const std::string& path)>& read) {
  std::map<std::string_view, std::string> values;  // by the current path
  for (const Renamed& renamed : kRenamed) {
    YamlReader* const section = SectionOf(file, renamed.before);
    if (section == nullptr) continue;
    const std::string key = NameOf(renamed.before);
    std::string value;
    section->Read(key, &value);
    const auto [first, is_new] = values.emplace(renamed.now, value);
    if (!is_new && !IsSameValue(first->second, value)) {
      section->Refuse(key, "two settings of the file are " + std::string(renamed.now) +
                               " now, and their values differ: set that one");
    }
    read(*section, key, std::string(renamed.now));
  }
  for (const GoneSettings& group : kGone) {
    for (const Former& former : group.settings) {
      YamlReader* const section = SectionOf(file, former.path);
      if (section == nullptr) continue;
      const std::string key = NameOf(former.path);
      std::string value;
      section->Read(key, &value);
      if (IsSameValue(value, std::string(former.usual))) continue;
      section->Refuse(key, WhyGone(former.path, group.reason));
    }
  }
}

}  // namespace highwall::apps
