// highwall_bench_points: matching quality of descriptors as the 256 bits that the system compares.
// Two images of a generated room at different times, with known correspondences of points.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/frontend/features/orb_extractor.h>
#include <highwall/frontend/features/orb_matcher.h>

#include "bench_main.h"
#include "cli/option_checks.h"
#include "features/descriptor_bits.h"
#include "features/sift_extractor.h"
#include "files/json_text.h"
#include "scenes.h"

namespace highwall::bench {
namespace {

constexpr double kRatio = 0.8;  // as in Relocalizer
constexpr double kRight = 3.0;  // [px] maximum error of a correct match
constexpr double kSeconds = 20.0;

struct Arguments {
  std::vector<std::string> detectors{"orb", "sift"};
  std::vector<int> gaps{2, 5, 10};  // [frames] of 0.1 s
  int seeds = 3;
  bool json = false;
};

// View of a room.
struct View {
  simulate::SimulatedFrame frame;
  ExtractedPoints points;
  cv::Mat bits;
};

View Look(const simulate::Simulation& room, int frame, PointExtractor& extractor,
          const DescriptorBits& bits) {
  View view{.frame = room.Render(frame), .points = {}, .bits = {}};
  cv::Mat gray;
  cv::cvtColor(view.frame.bgr, gray, cv::COLOR_BGR2GRAY);
  view.points = extractor.Extract(gray);
  view.bits = bits.Of(view.points.descriptors);
  return view;
}

// Returns the true position of keypoint i of a in b [px]; empty without depth, or outside of b's
// image.
std::optional<Eigen::Vector2d> TruePlace(const View& a, std::size_t i, const View& b,
                                         const PinholeCamera& camera) {
  const cv::Point2f at = a.points.keypoints[i].pt;
  const double depth = static_cast<double>(a.frame.depth.at<float>(cvRound(at.y), cvRound(at.x)));
  if (depth <= 0.0) return std::nullopt;
  const Eigen::Vector3d p_B =
      b.frame.T_WC.Inverse() * (a.frame.T_WC * camera.Unproject({at.x, at.y}, depth));
  if (p_B.z() <= 0.1) return std::nullopt;
  const Eigen::Vector2d uv = camera.Project(p_B);
  return camera.Contains(uv) ? std::optional(uv) : std::nullopt;
}

// Returns mutual nearest neighbours that pass the ratio test, in the extractor's own metric.
std::vector<FeatureMatch> MatchNatively(const View& a, const View& b, DescriptorType type) {
  const cv::BFMatcher matcher(type == DescriptorType::kFloat ? cv::NORM_L2 : cv::NORM_HAMMING);
  std::vector<std::vector<cv::DMatch>> there, back;
  matcher.knnMatch(a.points.descriptors, b.points.descriptors, there, 2);
  matcher.knnMatch(b.points.descriptors, a.points.descriptors, back, 1);
  std::vector<FeatureMatch> matches;
  for (const auto& pair : there) {
    if (pair.size() < 2 ||
        static_cast<double>(pair[0].distance) >= kRatio * static_cast<double>(pair[1].distance)) {
      continue;
    }
    const auto& returned = back[static_cast<std::size_t>(pair[0].trainIdx)];
    if (returned[0].trainIdx == pair[0].queryIdx) {
      matches.push_back({pair[0].queryIdx, pair[0].trainIdx, 0});
    }
  }
  return matches;
}

// Sums over pairs of views with one gap.
struct Tally {
  int pairs = 0, points = 0, in_both = 0;
  int native = 0, native_right = 0, bits = 0, bits_right = 0;
  std::vector<int> right, wrong;  // [bit] between true pairs; to the nearest other keypoint

  void Add(const View& a, const View& b, const PinholeCamera& camera, DescriptorType type) {
    ++pairs;
    points += static_cast<int>(a.points.keypoints.size());
    std::vector<std::optional<Eigen::Vector2d>> places;
    for (std::size_t i = 0; i < a.points.keypoints.size(); ++i) {
      places.push_back(TruePlace(a, i, b, camera));
      if (places.back()) AddDistances(a, static_cast<int>(i), b, *places.back());
    }
    const auto is_right = [&](const FeatureMatch& match) {
      const auto& place = places[static_cast<std::size_t>(match.query)];
      return place && IsAt(b, match.train, *place);
    };
    const auto count_right = [&](const std::vector<FeatureMatch>& matches) {
      return static_cast<int>(std::ranges::count_if(matches, is_right));
    };
    const auto natively = MatchNatively(a, b, type);
    const auto by_bits = MatchDescriptors(a.bits, b.bits, {.max_distance = 256, .ratio = kRatio});
    native += static_cast<int>(natively.size());
    native_right += count_right(natively);
    bits += static_cast<int>(by_bits.size());
    bits_right += count_right(by_bits);
  }

 private:
  static bool IsAt(const View& b, int j, const Eigen::Vector2d& place) {
    const cv::Point2f& at = b.points.keypoints[static_cast<std::size_t>(j)].pt;
    return std::hypot(static_cast<double>(at.x) - place.x(),
                      static_cast<double>(at.y) - place.y()) <= kRight;
  }
  void AddDistances(const View& a, int i, const View& b, const Eigen::Vector2d& place) {
    int nearest_right = 257, nearest_wrong = 257;
    for (int j = 0; j < b.bits.rows; ++j) {
      int& nearest = IsAt(b, j, place) ? nearest_right : nearest_wrong;
      nearest = std::min(nearest, HammingDistance(a.bits.ptr(i), b.bits.ptr(j)));
    }
    if (nearest_right > 256) return;
    ++in_both;
    right.push_back(nearest_right);
    wrong.push_back(nearest_wrong);
  }
};

int Quantile(std::vector<int> values, double share) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

std::unique_ptr<PointExtractor> MakeExtractor(const std::string& detector) {
  if (detector == "sift") return std::make_unique<SiftExtractor>();
  return std::make_unique<OrbExtractor>();
}

nlohmann::ordered_json Measure(const std::string& detector, int gap, int seeds) {
  constexpr int kStep = 10;  // [frames]
  const auto extractor = MakeExtractor(detector);
  const FeatureType& kind = extractor->kind();
  const DescriptorBits bits(kind.descriptor, kind.columns);
  Tally tally;
  for (int seed = 1; seed <= seeds; ++seed) {
    const simulate::Simulation room = MakeRoom(seed, kSeconds);
    for (int first = 0; first + gap < room.size(); first += kStep) {
      tally.Add(Look(room, first, *extractor, bits), Look(room, first + gap, *extractor, bits),
                room.options().camera, kind.descriptor);
    }
  }
  const auto mean = [&](int count) { return static_cast<double>(count) / tally.pairs; };
  const auto share = [](int part, int all) {
    return all > 0 ? static_cast<double>(part) / all : 0.0;
  };
  return {{"detector", detector},
          {"gap_s", 0.1 * gap},
          {"points", mean(tally.points)},
          {"in_both", mean(tally.in_both)},
          {"native_right", mean(tally.native_right)},
          {"native_precision", share(tally.native_right, tally.native)},
          {"bits_right", mean(tally.bits_right)},
          {"bits_precision", share(tally.bits_right, tally.bits)},
          {"right_bits_median", Quantile(tally.right, 0.5)},
          {"right_bits_90", Quantile(tally.right, 0.9)},
          {"wrong_bits_10", Quantile(tally.wrong, 0.1)},
          {"wrong_bits_median", Quantile(tally.wrong, 0.5)}};
}

void Run(const Arguments& arguments) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  if (!arguments.json) {
    fmt::print(
        "detector  gap [s]  points  in both   own metric: right  precision   bits: right  "
        "precision   right [bit] 50 % 90 %   nearest wrong 10 % 50 %\n");
  }
  for (const std::string& detector : arguments.detectors) {
    for (const int gap : arguments.gaps) {
      const nlohmann::ordered_json row = Measure(detector, gap, arguments.seeds);
      rows.push_back(row);
      if (arguments.json) continue;
      const auto number = [&](const char* name) { return row[name].get<double>(); };
      fmt::print(
          "{:8}  {:7.1f}  {:6.0f}  {:7.0f}  {:18.0f}  {:9.3f}  {:12.0f}  {:9.3f}  {:17.0f} "
          "{:4.0f}  {:18.0f} {:4.0f}\n",
          detector, number("gap_s"), number("points"), number("in_both"), number("native_right"),
          number("native_precision"), number("bits_right"), number("bits_precision"),
          number("right_bits_median"), number("right_bits_90"), number("wrong_bits_10"),
          number("wrong_bits_median"));
    }
  }
  if (arguments.json) fmt::print("{}\n", apps::JsonText(rows));
}

void AddOptions(CLI::App& app, Arguments& arguments) {
  AddList(app, "--detectors", arguments.detectors, {"orb", "sift"});
  app.add_option("--gaps", arguments.gaps, "Frames of 0.1 s from one image to the other")
      ->delimiter(',')
      ->check(apps::Between(1, 100))
      ->capture_default_str();
  app.add_option("--seeds", arguments.seeds, "Rooms")
      ->check(apps::Between(1, 100))
      ->capture_default_str();
  app.add_flag("--json", arguments.json, "Print the figures as JSON");
}

}  // namespace
}  // namespace highwall::bench

int main(int argc, char** argv) {
  using namespace highwall::bench;
  return RunBench<Arguments>(
      {"highwall_bench_points", "Descriptors of points as the 256 bits that the system compares"},
      argc, argv, AddOptions, Run);
}
