#include "simulate/scenes/kidnap.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>

#include <Eigen/Core>

#include "simulate/motion/look.h"
#include "simulate/motion/spline_trajectory.h"
#include "simulate/random.h"
#include "simulate/scenes/room.h"
#include "simulate/scenes/twin_rooms.h"

namespace highwall::simulate {
namespace {

using std::numbers::pi;
constexpr double kDegree = pi / 180.0;
constexpr double kTurnInterval = 0.8;  // [s]

// Walk around the middle of a room, the camera looking outwards, leg by leg.
class Walk {
 public:
  // half [m]: of the room, whose middle is free for a walk of two fifths of its size.
  Walk(double azimuth, const Eigen::Vector3d& middle, const Eigen::Vector2d& half)
      : turns_{{0.0, azimuth, middle, half}} {}

  double duration() const { return turns_.back().t; }

  // Continues by `angle` [rad] within `duration` [s].
  Interval Turn(double angle, double duration) {
    Place next = turns_.back();
    next.t += duration;
    next.azimuth += angle;
    turns_.push_back(next);
    return {next.t - duration, next.t};
  }
  // Stands still while the camera is carried into another room and rotated; the curve on either
  // side of the transition is independent of it.
  Interval Carry(double angle, const Eigen::Vector3d& middle, const Eigen::Vector2d& half) {
    const Interval before = Turn(0.0, 2 * kTurnInterval);
    Place there = turns_.back();
    there.azimuth += angle;
    there.middle = middle;
    there.half = half;
    turns_.push_back(there);
    return {before.begin, Turn(0.0, 2 * kTurnInterval).end};
  }

  // Adds hand motion. The curve continues beyond the duration, and only closes there.
  SplineTrajectory Trajectory(RandomSequence* random) const {
    const int knots = static_cast<int>(std::ceil(duration() / kTurnInterval)) + 4;
    const double phase = random->Uniform(-pi, pi), period = random->Uniform(9.0, 12.0);
    std::vector<Pose> control;
    for (int i = 0; i < knots; ++i) {
      const double t = (i - 1) * kTurnInterval;  // time at which the curve is closest to this knot
      const Place place = At(t);
      const double wave = std::sin(2 * pi * t / period + phase);
      const Eigen::Vector2d axes = (0.31 + 0.09 * wave) * place.half;
      const Eigen::Vector3d p_WC =
          place.middle + Eigen::Vector3d(axes.x() * std::cos(place.azimuth) + Hand(0.03, random),
                                         axes.y() * std::sin(place.azimuth) + Hand(0.03, random),
                                         1.3 + Hand(0.08, random));
      control.emplace_back(Look(place.azimuth + 0.12 * wave + Hand(0.07, random),
                                -0.2 + Hand(0.08, random), Hand(0.05, random)),
                           p_WC);
    }
    return SplineTrajectory(std::move(control), knots * kTurnInterval);
  }

 private:
  struct Place {
    double t;        // [s]
    double azimuth;  // [rad]
    Eigen::Vector3d middle;
    Eigen::Vector2d half;
  };

  static double Hand(double most, RandomSequence* random) { return random->Uniform(-most, most); }

  Place At(double t) const {
    t = std::clamp(t, 0.0, duration());
    std::size_t next = 1;
    while (next + 1 < turns_.size() && turns_[next].t < t) ++next;
    const Place &a = turns_[next - 1], &b = turns_[next];
    const double w = b.t > a.t ? (t - a.t) / (b.t - a.t) : 1.0;
    return {t, a.azimuth + w * (b.azimuth - a.azimuth), a.middle + w * (b.middle - a.middle),
            a.half + w * (b.half - a.half)};
  }

  std::vector<Place> turns_;
};

PartedSimulation MakeParted(Scene scene, const Walk& walk, std::vector<Interval> ways,
                            SimulationOptions options, RandomSequence* random) {
  options.duration = walk.duration();
  return {Simulation(std::move(scene), walk.Trajectory(random), options), std::move(ways)};
}

}  // namespace

std::optional<int> PartedSimulation::PartAt(double t) const {
  int part = 0;
  for (const Interval& way : ways) {
    if (way.Contains(t)) return std::nullopt;
    if (t >= way.end) ++part;
  }
  return part;
}

WayBack WayBackOf(std::uint64_t seed) {
  switch (seed % 4) {
    case 0:
      return WayBack::kPutBack;
    case 2:
      return WayBack::kReturn;
    default:
      return WayBack::kOnward;
  }
}

PartedSimulation SimulateKidnap(const SimulationOptions& options) {
  // Angle into a previously seen part at which most of the image shows it.
  constexpr double kInto = 50.0 * kDegree;
  constexpr double kWay = 3.0, kLongWay = 4.0;  // [s]
  RandomSequence random(Mix(options.seed ^ 0x6b69646eu));
  Walk walk(random.Uniform(-pi, pi), Eigen::Vector3d::Zero(), {3.0, 2.5});
  const double sense = random.Index(2) == 0 ? 1.0 : -1.0;
  // The gap between the parts is wider than the field of view.
  const double first = random.Uniform(85.0, 105.0) * kDegree;
  const double gap = random.Uniform(75.0, 85.0) * kDegree;
  const double last_gap = random.Uniform(80.0, 100.0) * kDegree;
  const double second = 2 * pi - first - gap - last_gap;
  walk.Turn(sense * first, random.Uniform(6.0, 8.0));
  std::vector<Interval> ways = {walk.Turn(sense * gap, kWay)};
  const double while_there = random.Uniform(5.0, 8.0);
  switch (WayBackOf(options.seed)) {
    case WayBack::kOnward:
      walk.Turn(sense * second, while_there);
      walk.Turn(sense * (last_gap + kInto), 8.0);
      break;
    case WayBack::kReturn:
      walk.Turn(0.5 * sense * second, 0.5 * while_there);
      walk.Turn(-0.5 * sense * second, 0.5 * while_there);
      walk.Turn(-sense * (gap + kInto), 8.0);
      break;
    case WayBack::kPutBack:
      walk.Turn(sense * second, while_there);
      ways.push_back(walk.Turn(sense * (last_gap + 0.5 * first), kLongWay));
      walk.Turn(-0.5 * sense * first, 3.0);
      walk.Turn(-sense * (last_gap + kInto), 7.0);
      break;
  }
  return MakeParted(MakeRoom(options.seed), walk, std::move(ways), options, &random);
}

PartedSimulation SimulateTwinRooms(const SimulationOptions& options) {
  RandomSequence random(Mix(options.seed ^ 0x7477696eu));
  TwinRooms twins = MakeTwinRooms(options.seed);
  Walk walk(random.Uniform(-pi, pi), twins.rooms[0].middle, twins.rooms[0].half);
  const double sense = random.Index(2) == 0 ? 1.0 : -1.0;
  const auto sweep = [&] { return sense * random.Uniform(200.0, 280.0) * kDegree; };
  walk.Turn(sweep(), random.Uniform(11.0, 13.0));
  const Interval way =
      walk.Carry(random.Uniform(-pi, pi), twins.rooms[1].middle, twins.rooms[1].half);
  walk.Turn(sweep(), random.Uniform(11.0, 13.0));
  return MakeParted(std::move(twins.scene), walk, {way}, options, &random);
}

}  // namespace highwall::simulate
