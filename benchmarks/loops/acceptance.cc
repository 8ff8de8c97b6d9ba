#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <fmt/core.h>
#include <highwall/internal/median.h>
#include <nlohmann/json.hpp>

#include "bench_loops.h"
#include "loops/loop_correction.h"
#include "loops/loop_detector.h"
#include "support/loop_scene.h"
#include "support/ring_map.h"
#include "timing.h"

namespace highwall::bench {
namespace {

using testing::OdometryDrift;
using testing::RingMap;

constexpr int kLoopsPerWalk = 10;  // of each kind
const KeyFrameGraphOptions kOptions;

struct Count {
  int asked = 0, accepted = 0;
  void Add(bool taken) { ++asked, accepted += taken; }
  nlohmann::json ToJson() const { return {{"asked", asked}, {"accepted", accepted}}; }
};

struct Tally {
  Count true_loops, inside, outside, metres;
  std::vector<double> chi2;  // of the true loops
  double chi2_seconds = 0.0, correction_seconds = 0.0;
  int chi2_calls = 0, corrections = 0;
};

// Tests loops on a drifted walk as in the system: the drift test, then the pose graph.
class Walk {
 public:
  Walk(RingMap* ring, unsigned seed, Tally* tally) : ring_(*ring), rng_(seed), tally_(*tally) {}

  void Ask() {
    for (int k = 0; k < kLoopsPerWalk; ++k) {
      const auto [match, keyframe] = Ends(k == 0);
      const Pose Z_true = ring_.Loop(match, keyframe).Z;
      const LoopEdge seen{match, keyframe, Z_true * Noise()};
      tally_.chi2.push_back(Chi2(seen));
      tally_.true_loops.Add(Accepts(seen));
      // The pose of the keyframe in the map is offset in a random direction, by a distance within
      // or beyond the possible drift.
      const LoopEdge none{match, keyframe, At(match).T_WC.Inverse() * At(keyframe).T_WC};
      const Eigen::Matrix<double, 6, 1> way = Direction();
      const double farthest = std::sqrt(kOptions.max_loop_chi2 / Chi2(Off(none, way, 1e-3))) * 1e-3;
      tally_.inside.Add(Accepts(Off(none, way, 0.9 * farthest)));
      tally_.outside.Add(Accepts(Off(none, way, 1.1 * farthest)));
      Eigen::Matrix<double, 6, 1> aside = Eigen::Matrix<double, 6, 1>::Zero();
      aside.head<3>() = Direction().head<3>().normalized();
      tally_.metres.Add(Accepts(Off({match, keyframe, Z_true}, aside, 3.0)));
    }
  }

 private:
  const KeyFrame& At(KeyFrameId id) const { return *ring_.map.keyframe(id); }

  // Returns the ends of a loop over half of the walk or more; whole: over all of it.
  std::pair<KeyFrameId, KeyFrameId> Ends(bool whole) {
    const int last = ring_.last().value();
    if (whole) return {KeyFrameId(0), KeyFrameId(last)};
    const int match = static_cast<int>(testing::Uniform(rng_, 0.0, 0.5) * last);
    const int way = static_cast<int>(testing::Uniform(rng_, 0.5, 1.0) * last);
    return {KeyFrameId(match), KeyFrameId(std::min(last, match + way))};
  }

  // Returns metres and radians in the proportion of a loop's noise.
  Eigen::Matrix<double, 6, 1> Direction() {
    std::normal_distribution<double> normal;
    Eigen::Matrix<double, 6, 1> way;
    for (int k = 0; k < 6; ++k) {
      way[k] = normal(rng_) * (k < 3 ? kOptions.loop_translation : kOptions.loop_rotation);
    }
    return way;
  }
  Pose Noise() {
    const auto noise = Direction();
    return Pose::FromTangent(noise.head<3>(), noise.tail<3>());
  }
  static LoopEdge Off(LoopEdge loop, const Eigen::Matrix<double, 6, 1>& way, double far) {
    loop.Z =
        loop.Z * Pose(Pose::FromTangent({0, 0, 0}, far * way.tail<3>()).q(), far * way.head<3>());
    return loop;
  }

  double Chi2(const LoopEdge& loop) {
    double chi2 = 0.0;
    tally_.chi2_seconds += WallSeconds([&] {
      chi2 = *LoopChi2(MakeKeyFrameGraph(ring_.map, model_, {}, kOptions), loop, kOptions);
    });
    ++tally_.chi2_calls;
    return chi2;
  }
  bool Accepts(const LoopEdge& loop) {
    if (Chi2(loop) > kOptions.max_loop_chi2) return false;  // rejected by the detector
    Map map = ring_.map.Clone();
    LoopCorrectionResult result;
    tally_.correction_seconds +=
        WallSeconds([&] { result = CorrectLoop({}, {.edge = loop}, model_, {}, {}, &map); });
    ++tally_.corrections;
    return result.accepted;
  }

  RingMap& ring_;
  std::mt19937 rng_;
  Tally& tally_;
  const MeasurementModel model_{testing::IdealSensor(), {}};
};

nlohmann::json Report(int keyframes, bool levelled, double bias, const Tally& tally) {
  const double chi2_ms = 1e3 * tally.chi2_seconds / tally.chi2_calls;
  const double correction_ms = 1e3 * tally.correction_seconds / std::max(1, tally.corrections);
  const auto percent = [](const Count& count) { return 100.0 * count.accepted / count.asked; };
  fmt::print(
      stderr,
      "{:5} keyframes {:15} bias {:.2f} deg: accepted {:.1f} % of {} true loops (chi2 {:.2f} "
      "in the median, {:.1f} at most), {:.1f} % within the drift, {:.1f} % beyond it, {:.1f} "
      "% 3 m off; {:.1f} ms to judge, {:.1f} ms to close\n",
      keyframes, levelled ? "with gravity" : "without gravity", bias, percent(tally.true_loops),
      tally.true_loops.asked, UpperMedian(tally.chi2),
      *std::max_element(tally.chi2.begin(), tally.chi2.end()), percent(tally.inside),
      percent(tally.outside), percent(tally.metres), chi2_ms, correction_ms);
  return {{"keyframes", keyframes},
          {"gravity", levelled},
          {"bias_deg", bias},
          {"true", tally.true_loops.ToJson()},
          {"inside", tally.inside.ToJson()},
          {"outside", tally.outside.ToJson()},
          {"three_metres", tally.metres.ToJson()},
          {"true_chi2_median", UpperMedian(tally.chi2)},
          {"chi2_ms", chi2_ms},
          {"correction_ms", correction_ms}};
}

// Returns the loops that geometry verifies, regardless of the drift, in walks to a place that
// shares some of its landmarks with the start, or has the same appearance elsewhere.
nlohmann::json Verified(int seeds, double strange, bool shuffled) {
  int verified = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    testing::LoopScene scene({.odometry = OdometryDrift{.seed = static_cast<unsigned>(seed)},
                              .shuffled_return = shuffled,
                              .strange_return = strange,
                              .seed = static_cast<unsigned>(seed)});
    LoopDetector detector(scene.model, {}, {.max_loop_chi2 = 1e12});
    bool found = false;
    for (int i = 0; i < scene.size() && !found; ++i) {
      found = detector.Detect(scene.map, scene.Add(i), {}).has_value();
    }
    verified += found;
  }
  const std::string kind =
      shuffled ? "the looks of the first in other places"
               : fmt::format("{:.0f} % of the first's landmarks", 100.0 * (1.0 - strange));
  fmt::print(stderr, "a second place with {}: verified in {} of {} walks\n", kind, verified, seeds);
  return {{"second_place", kind}, {"walks", seeds}, {"verified", verified}};
}

}  // namespace

nlohmann::json BenchAcceptance(const std::vector<int>& sizes, int seeds) {
  nlohmann::json rows = nlohmann::json::array(), repeated = nlohmann::json::array();
  for (const int keyframes : sizes) {
    RingMap ring(keyframes);
    for (const double bias : {0.01, 0.1}) {  // [deg] per keyframe: 0.1 and 1 times the noise
      for (const bool levelled : {false, true}) {
        Tally tally;
        for (int seed = 1; seed <= seeds; ++seed) {
          const auto s = static_cast<unsigned>(seed);
          ring.Drift({.bias_rotation = bias * M_PI / 180.0, .seed = s}, levelled);
          Walk(&ring, 1000 + s, &tally).Ask();
        }
        rows.push_back(Report(keyframes, levelled, bias, tally));
      }
    }
  }
  for (const double strange : {0.0, 0.25, 0.5, 0.6, 0.7, 0.8, 0.9}) {
    repeated.push_back(Verified(seeds, strange, false));
  }
  repeated.push_back(Verified(seeds, 0.0, true));
  return {{"loops", rows}, {"repeated", repeated}};
}

}  // namespace highwall::bench
