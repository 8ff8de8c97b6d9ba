#include "simulate/scenes/room.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "simulate/materials/prints.h"
#include "simulate/motion/look.h"
#include "simulate/random.h"
#include "simulate/scenes/furniture.h"
#include "simulate/scenes/visitor.h"

namespace highwall::simulate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

using std::numbers::pi;
constexpr double kHalfX = 3.0, kHalfY = 2.5, kRoomHeight = 3.0;  // [m]

class RoomBuilder : private Furnisher {
 public:
  explicit RoomBuilder(std::uint64_t seed) : Furnisher(seed) {}

  Scene Build() {
    BuildShell();
    FurnishBrickWall();
    FurnishDeskWall();
    FurnishPlasterWall();
    FurnishShelfWall();
    AddBoxesInCorners();
    return std::move(scene_);
  }

 private:
  void BuildShell() {
    const int floor = AddMasonry({.cell = {0.5f, 0.5f},
                                  .joint = 0.008f,
                                  .shift = 0.0f,
                                  .checker = true,
                                  .first = Rgb(0.72, 0.66, 0.56),
                                  .second = Rgb(0.4, 0.38, 0.38),
                                  .joint_colour = Rgb(0.2, 0.2, 0.2),
                                  .contrast = 0.4f,
                                  .noise = {.wavelength = 0.12f, .octaves = 4}});
    const int ceiling = AddMasonry({.cell = {0.6f, 0.6f},
                                    .joint = 0.02f,
                                    .shift = 0.0f,
                                    .first = Rgb(0.8, 0.8, 0.78),
                                    .second = Rgb(0.75, 0.75, 0.72),
                                    .joint_colour = Rgb(0.45, 0.45, 0.45),
                                    .contrast = 0.3f,
                                    .noise = {.wavelength = 0.03f, .octaves = 2}});
    scene_.AddRectangle({-kHalfX, -kHalfY, 0}, {2 * kHalfX, 0, 0}, {0, 2 * kHalfY, 0}, floor);
    scene_.AddRectangle({-kHalfX, kHalfY, kRoomHeight}, {2 * kHalfX, 0, 0}, {0, -2 * kHalfY, 0},
                        ceiling);
    AddWall(bricks_, kRoomHeight,
            AddMasonry({.contrast = 0.5f, .noise = {.wavelength = 0.06f, .octaves = 4}}));
    AddWall(desk_, kRoomHeight, AddNoise(Rgb(0.72, 0.74, 0.66), 0.12, 0.25, 6));
    AddWall(plaster_, kRoomHeight, AddNoise(Rgb(0.74, 0.7, 0.62), 0.16, 0.25, 6));
    AddWall(shelf_, kRoomHeight,
            AddMasonry({.cell = {0.24f, 4.0f},
                        .joint = 0.012f,
                        .shift = 0.0f,
                        .checker = true,
                        .first = Rgb(0.5, 0.6, 0.62),
                        .second = Rgb(0.62, 0.7, 0.7),
                        .joint_colour = Rgb(0.85, 0.82, 0.7),
                        .contrast = 0.18f,
                        .noise = {.wavelength = 0.08f, .octaves = 4}}));
    for (const Vector2d& xy : {Vector2d(-1.6, -1.0), Vector2d(1.6, -1.0), Vector2d(0.0, 1.4)}) {
      scene_.lights.push_back({{xy.x(), xy.y(), 2.8}, 1.9});
    }
  }

  void FurnishBrickWall() {
    AddCupboard(bricks_, -1.75, {1.3, 0.45, 0.85}, 3, 2);
    AddCardboardBox(bricks_, {-2.0, 0.24, 0.85}, {0.36, 0.28, 0.26});
    AddOn(bricks_, {-1.45, 0.85}, {0.3, 0.2, 0.04}, {dark_, dark_, wood_});
    AddPicture(bricks_, {-1.5, 1.75}, {0.8, 0.6}, false);
    AddPicture(bricks_, {0.1, 1.55}, {0.6, 0.85}, false);
    AddPicture(bricks_, {0.85, 1.75}, {0.3, 0.42}, true);
    AddTable(bricks_, 1.75, {1.4, 0.6, 0.72});
    AddCardboardBox(bricks_, {1.4, 0.3, 0.72}, {0.42, 0.3, 0.32});
    AddCardboardBox(bricks_, {2.0, 0.28, 0.72}, {0.34, 0.3, 0.22});
    AddOn(bricks_, {1.8, 1.55}, {1.1, 0.22, 0.03}, {wood_, wood_, wood_});
    const int books = scene_.AddTexture(MakeBooks({0.5, 0.25}, &random_));
    AddOn(bricks_, {1.6, 1.58}, {0.5, 0.17, 0.25}, {dark_, books, white_});
  }

  void FurnishDeskWall() {
    AddTable(desk_, 0.2, {1.7, 0.7, 0.74});
    for (const double x : {-0.15, 0.5}) {
      const int screen = scene_.AddTexture(MakeScreen({0.56, 0.36}, &random_));
      AddFree(desk_, {x, 0.3, 0.74}, {0.18, 0.14, 0.02}, 0.0, {dark_, dark_, dark_});
      AddFree(desk_, {x, 0.27, 0.76}, {0.04, 0.03, 0.1}, 0.0, {dark_, dark_, dark_});
      AddFree(desk_, {x, 0.3, 0.84}, {0.56, 0.04, 0.36}, x < 0 ? -0.2 : 0.2,
              {dark_, screen, dark_});
    }
    const int keys =
        scene_.AddTexture(MakePanels({0.42, 0.14}, 4, 12, Rgb(0.7, 0.7, 0.7), &random_));
    AddFree(desk_, {0.1, 0.55, 0.74}, {0.42, 0.14, 0.02}, random_.Uniform(-0.1, 0.1),
            {dark_, dark_, keys});
    AddFree(desk_, {-0.5, 0.45, 0.74}, {0.22, 0.3, 0.06}, 0.3, {white_, dark_, wood_});
    AddFree(desk_, {0.85, 0.5, 0.74}, {0.08, 0.08, 0.1}, 0.5, {white_, white_, dark_});
    AddCupboard(desk_, -1.2, {0.5, 0.5, 0.62}, 3, 1);
    AddCardboardBox(desk_, {-1.2, 0.25, 0.62}, {0.32, 0.24, 0.2});
    AddPicture(desk_, {0.2, 1.75}, {1.3, 0.6}, false);
    AddPicture(desk_, {-1.1, 1.6}, {0.5, 0.7}, true);
    AddPicture(desk_, {1.55, 1.6}, {0.6, 0.8}, false);
  }

  void FurnishPlasterWall() {
    const int panelling = AddMasonry({.cell = {0.13f, 4.0f},
                                      .joint = 0.008f,
                                      .shift = 0.0f,
                                      .first = Rgb(0.66, 0.56, 0.42),
                                      .second = Rgb(0.56, 0.48, 0.36),
                                      .joint_colour = Rgb(0.25, 0.2, 0.15),
                                      .contrast = 0.3f,
                                      .stretch = {1.0f, 0.15f},
                                      .noise = {.wavelength = 0.03f, .octaves = 3}});
    AddOn(plaster_, {0.0, 0.0}, {plaster_.length, 0.012, 0.9}, {wood_, panelling, wood_});
    AddPicture(plaster_, {-2.5, 1.55}, {0.45, 0.6}, false);
    const int door =
        scene_.AddTexture(MakePanels({0.9, 2.05}, 4, 2, Rgb(0.7, 0.55, 0.38), &random_));
    AddOn(plaster_, {-1.5, 0.0}, {1.06, 0.05, 2.13}, {white_, white_, white_});
    AddOn(plaster_, {-1.5, 0.0}, {0.9, 0.07, 2.05}, {wood_, door, wood_});
    AddPicture(plaster_, {-0.35, 1.5}, {0.5, 0.65}, true);
    AddPicture(plaster_, {0.4, 1.6}, {0.6, 0.5}, false);
    AddCupboard(plaster_, 1.1, {1.6, 0.4, 0.7}, 2, 4);
    const int print = scene_.AddTexture(MakeBooks({0.6, 0.28}, &random_));
    AddOn(plaster_, {0.8, 0.7}, {0.6, 0.2, 0.28}, {dark_, print, white_});
    AddCardboardBox(plaster_, {1.5, 0.2, 0.7}, {0.3, 0.22, 0.25});
    AddPicture(plaster_, {1.6, 1.65}, {0.9, 0.7}, false);
  }

  void FurnishShelfWall() {
    AddBookshelf(shelf_, -1.0, {1.1, 0.32, 2.0}, 6);
    AddBookshelf(shelf_, 0.2, {0.9, 0.3, 1.2}, 4);
    AddCardboardBox(shelf_, {0.2, 0.16, 1.2}, {0.4, 0.26, 0.28});
    AddPicture(shelf_, {0.3, 1.95}, {0.7, 0.45}, false);
    AddPicture(shelf_, {1.4, 1.5}, {0.7, 0.9}, false);
    AddCupboard(shelf_, 1.4, {0.7, 0.4, 0.6}, 2, 1);
  }

  void AddBoxesInCorners() {
    AddCardboardBox(desk_, {1.75, 0.4, 0.0}, {0.55, 0.45, 0.5});
    AddCardboardBox(desk_, {1.8, 0.4, 0.5}, {0.4, 0.36, 0.34});
    AddCardboardBox(plaster_, {2.45, 0.4, 0.0}, {0.5, 0.45, 0.42});
    AddCardboardBox(shelf_, {-1.95, 0.35, 0.0}, {0.5, 0.4, 0.6});
    AddCardboardBox(bricks_, {0.35, 0.3, 0.0}, {0.6, 0.4, 0.4});
  }

  const Wall bricks_ = MakeWall(0.0, kHalfY, 2 * kHalfX);      // +y
  const Wall desk_ = MakeWall(-0.5 * pi, kHalfX, 2 * kHalfY);  // +x
  const Wall plaster_ = MakeWall(pi, kHalfY, 2 * kHalfX);      // -y
  const Wall shelf_ = MakeWall(0.5 * pi, kHalfX, 2 * kHalfY);  // -x
};

}  // namespace

Scene MakeRoom(std::uint64_t seed) {
  return RoomBuilder(seed).Build();
}

SplineTrajectory MakeRoomTrajectory(double duration, std::uint64_t seed, double longest_lap) {
  constexpr double kSpeed = 0.45;        // [m/s]
  constexpr double kShortestLap = 10.0;  // [s]
  constexpr double kKnotInterval = 0.8;  // [s]
  const double period = std::max(kShortestLap, duration / std::ceil(duration / longest_lap));
  const double radius = kSpeed * period / (2 * pi);
  const Vector2d axes(1.1 * radius, 0.9 * radius);  // the room is longer than wide

  RandomSequence random(Mix(seed));
  const double start = random.Uniform(-pi, pi);
  const int knots = static_cast<int>(std::lround(period / kKnotInterval));
  std::vector<Pose> control;
  for (int i = 0; i < knots; ++i) {
    const double azimuth = start + 2 * pi * i / knots;
    const Vector3d p_WC(axes.x() * std::cos(azimuth) + random.Uniform(-0.03, 0.03),
                        axes.y() * std::sin(azimuth) + random.Uniform(-0.03, 0.03),
                        1.3 + random.Uniform(-0.08, 0.08));
    control.emplace_back(Look(azimuth + random.Uniform(-0.07, 0.07),
                              -0.2 + random.Uniform(-0.08, 0.08), random.Uniform(-0.05, 0.05)),
                         p_WC);
  }
  return SplineTrajectory(std::move(control), period);
}

Simulation SimulateRoom(const SimulationOptions& options) {
  options.Validate();
  const double moving = std::max(1.0, CameraPath::MovingTime(options.duration, options.rest));
  const double longest_lap = options.traffic ? kLongestLapWithVisitor : 20.0;  // [s]
  Scene room = MakeRoom(options.seed);
  SplineTrajectory walk = MakeRoomTrajectory(moving, options.seed, longest_lap);
  MovingScene visitor = MakeVisitor(CameraPath(walk, options.rest), room.lights, room.ambient);
  return Simulation(std::move(room), std::move(walk), options, {}, {}, std::move(visitor));
}

}  // namespace highwall::simulate
