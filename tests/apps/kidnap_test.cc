#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "simulate/camera/raycaster.h"
#include "simulate/scenes/kidnap.h"
#include "simulate/scenes/twin_rooms.h"
#include "support/seen_surface.h"

namespace highwall::simulate::kidnap_test {
namespace {

using testing::SeenSurface;

SimulationOptions SmallOptions(std::uint64_t seed) {
  SimulationOptions options;
  options.seed = seed;
  options.fps = 5.0;
  options.camera = {.width = 80, .height = 60, .fx = 65.6, .fy = 65.6, .cx = 39.5, .cy = 29.5};
  options.sensor.noise = SensorNoise::kOff;
  options.imu.enabled = false;
  return options;
}

double TimeOf(const Simulation& simulation, int i) {
  return ToSeconds(simulation.StampOf(i) - simulation.StampOf(0));
}

class Kidnap : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, Kidnap, ::testing::Range<std::uint64_t>(1, 9));

TEST_P(Kidnap, ComesToAPlaceItHasNotSeenAndBack) {
  const PartedSimulation parted = SimulateKidnap(SmallOptions(GetParam()));
  const Simulation& simulation = parted.simulation;
  SeenSurface first;
  bool carried = false, known_again = false;
  for (int i = 0; i < simulation.size(); ++i) {
    const auto part = parted.PartAt(TimeOf(simulation, i));
    if (!part) continue;
    const SimulatedFrame frame = simulation.Render(i);
    const auto points = SeenSurface::PointsOf(frame.depth, simulation.options().camera, frame.T_WC);
    if (*part == 0) {
      first.Add(points);
      continue;
    }
    const double share = first.ShareSeen(points);
    if (!carried) {
      EXPECT_LT(share, 0.05) << "the second part begins where the first was";
      carried = true;
    }
    known_again |= share > 0.6;
  }
  EXPECT_TRUE(carried);
  EXPECT_TRUE(known_again);
}

TEST_P(Kidnap, WalksAsSomebodyDoesOnTheWaysAsWell) {
  const PartedSimulation parted = SimulateKidnap(SmallOptions(GetParam()));
  const Simulation& simulation = parted.simulation;
  const double interval = 1.0 / simulation.options().fps;
  for (int i = 1; i < simulation.size(); ++i) {
    const Pose step = simulation.T_WC(simulation.StampOf(i - 1)).Inverse() *
                      simulation.T_WC(simulation.StampOf(i));
    EXPECT_LT(step.p().norm() / interval, 1.2) << "[m/s] at " << i * interval << " s";
    EXPECT_LT(step.Angle() / interval, 1.2) << "[rad/s] at " << i * interval << " s";
  }
}

TEST(Kidnap, LastsAsLongAsStatedAndReturnsOnEveryPath) {
  std::set<WayBack> ways_back;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    ways_back.insert(WayBackOf(seed));
    const PartedSimulation parted = SimulateKidnap(SmallOptions(seed));
    ASSERT_EQ(parted.ways.size(), WayBackOf(seed) == WayBack::kPutBack ? 2u : 1u);
    EXPECT_GE(parted.ways[0].begin, 6.0);
    EXPECT_LE(parted.ways[0].begin, 8.0);
    EXPECT_GE(parted.simulation.options().duration, parted.ways.back().end + 8.0);
    EXPECT_EQ(parted.PartAt(0.0), 0);
    EXPECT_EQ(parted.PartAt(parted.ways[0].begin), std::nullopt);
    EXPECT_EQ(parted.PartAt(parted.ways[0].end), 1);
  }
  EXPECT_EQ(ways_back.size(), 3u);
}

// Summarizes a texture by its colours at a few places.
std::vector<float> FingerprintOf(const Texture& texture) {
  std::vector<float> colours;
  for (const float s : {0.03f, 0.11f, 0.19f, 0.27f}) {
    for (const float t : {0.02f, 0.09f, 0.16f, 0.23f}) {
      const Colour colour = texture.Albedo({s, t}, 0.002f);
      colours.insert(colours.end(), colour.begin(), colour.end());
    }
  }
  return colours;
}

TEST(TwinRooms, HaveFurnitureOfOneCatalogueAndWallsOfTheirOwn) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const TwinRooms twins = MakeTwinRooms(seed);
    std::set<std::vector<float>> looks[2];
    const Scene& scene = twins.scene;
    for (const Surface& surface : scene.surfaces) {
      const bool second = surface.origin.x() > 0.5 * twins.rooms[1].middle.x();
      looks[second].insert(
          FingerprintOf(*scene.textures[static_cast<std::size_t>(surface.texture)]));
    }
    std::vector<std::vector<float>> common;
    std::ranges::set_intersection(looks[0], looks[1], std::back_inserter(common));
    EXPECT_GE(common.size(), 10u);
    constexpr std::size_t kShell = 6;  // four walls, floor and ceiling
    EXPECT_GE(looks[0].size() - common.size(), kShell);
    EXPECT_GE(looks[1].size() - common.size(), kShell);
    EXPECT_GT((twins.rooms[0].half - twins.rooms[1].half).cwiseAbs().minCoeff(), 0.09);
  }
}

TEST(TwinRooms, AreClosedAndTheWalkStaysInThem) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const TwinRooms twins = MakeTwinRooms(seed);
    const Raycaster raycaster(twins.scene.mesh);
    const PartedSimulation parted = SimulateTwinRooms(SmallOptions(seed));
    for (int i = 0; i < parted.simulation.size(); ++i) {
      const auto part = parted.PartAt(TimeOf(parted.simulation, i));
      if (!part) continue;
      const Pose T_WC = parted.simulation.T_WC(parted.simulation.StampOf(i));
      const TwinRooms::Room& room = twins.rooms[static_cast<std::size_t>(*part)];
      const Eigen::Array2d off = (T_WC.p() - room.middle).head<2>().array().abs();
      EXPECT_TRUE((off < room.half.array() - 0.9).all()) << "at " << T_WC.p().transpose();
      EXPECT_NE(raycaster.FirstTriangle(T_WC.p(), T_WC.q() * Eigen::Vector3d::UnitZ()),
                Raycaster::kNone);
    }
  }
}

}  // namespace
}  // namespace highwall::simulate::kidnap_test
