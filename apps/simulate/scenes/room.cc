#include "simulate/scenes/room.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "simulate/materials/prints.h"
#include "simulate/random.h"
#include "simulate/scenes/visitor.h"

namespace highwall::simulate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr double kHalfX = 3.0, kHalfY = 2.5, kHeight = 3.0;  // [m]

// A wall, seen from inside: x to the right along it, y into it, z up; the origin in the middle of
// its foot. Boxes placed here have their front towards the room.
struct Wall {
  Pose T_WL;
  double length;
};

Wall MakeWall(double yaw, double distance, double length) {
  const Eigen::Quaterniond q(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
  return {Pose(q, q * Vector3d(0.0, distance, 0.0)), length};
}

class RoomBuilder {
 public:
  explicit RoomBuilder(std::uint64_t seed) : random_(seed) {}

  Scene Build() {
    MakeMaterials();
    BuildShell();
    FurnishBrickWall();
    FurnishDeskWall();
    FurnishPlasterWall();
    FurnishShelfWall();
    AddBoxesInCorners();
    return std::move(scene_);
  }

 private:
  std::uint32_t Seed() { return static_cast<std::uint32_t>(random_.Bits()); }

  int AddNoise(const Colour& colour, double contrast, double wavelength, int octaves) {
    return scene_.AddTexture(std::make_unique<NoiseTexture>(
        colour, static_cast<float>(contrast),
        ValueNoise{static_cast<float>(wavelength), octaves, Seed()}));
  }

  int AddMasonry(MasonryOptions options) {
    options.noise.seed = Seed();
    return scene_.AddTexture(std::make_unique<MasonryTexture>(options));
  }

  void MakeMaterials() {
    const auto shade = static_cast<float>(random_.Uniform(0.85, 1.1));
    wood_ = AddMasonry({.cell = {1.7f, 0.14f},
                        .joint = 0.004f,
                        .shift = 0.37f,
                        .first = Rgb(0.62, 0.42, 0.24) * shade,
                        .second = Rgb(0.48, 0.3, 0.16) * shade,
                        .joint_colour = Rgb(0.25, 0.16, 0.09),
                        .contrast = 0.35f,
                        .stretch = {0.15f, 1.0f},
                        .noise = {.wavelength = 0.03f, .octaves = 3}});
    dark_ = AddNoise(Rgb(0.16, 0.15, 0.16), 0.3, 0.05, 3);
    white_ = AddNoise(Rgb(0.85, 0.85, 0.82), 0.05, 0.2, 3);
    metal_ = AddNoise(Rgb(0.45, 0.47, 0.5), 0.1, 0.1, 4);
    cardboard_ = AddNoise(Rgb(0.6, 0.45, 0.28), 0.2, 0.08, 4);
  }

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
    scene_.AddRectangle({-kHalfX, kHalfY, kHeight}, {2 * kHalfX, 0, 0}, {0, -2 * kHalfY, 0},
                        ceiling);
    AddWall(bricks_, AddMasonry({.contrast = 0.5f, .noise = {.wavelength = 0.06f, .octaves = 4}}));
    AddWall(desk_, AddNoise(Rgb(0.72, 0.74, 0.66), 0.12, 0.25, 6));
    AddWall(plaster_, AddNoise(Rgb(0.74, 0.7, 0.62), 0.16, 0.25, 6));
    AddWall(shelf_, AddMasonry({.cell = {0.24f, 4.0f},
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

  void AddWall(const Wall& wall, int texture) {
    scene_.AddRectangle(wall.T_WL * Vector3d(-0.5 * wall.length, 0, 0),
                        wall.T_WL.q() * Vector3d(wall.length, 0, 0), {0, 0, kHeight}, texture);
    AddOn(wall, {0, 0}, {wall.length, 0.02, 0.1}, {dark_, dark_, dark_});
    AddOn(wall, {0, kHeight - 0.08}, {wall.length, 0.03, 0.08}, {white_, white_, white_});
  }

  // A box with its back on the wall; x along the wall and z above the floor of the middle of its
  // foot.
  void AddOn(const Wall& wall, const Vector2d& xz, const Vector3d& size, const BoxTextures& box) {
    scene_.AddBox(
        wall.T_WL * Pose(Eigen::Quaterniond::Identity(), Vector3d(xz.x(), -0.5 * size.y(), xz.y())),
        size, box);
  }

  // A box anywhere, `out` metres from the wall to its middle, turned by yaw.
  void AddFree(const Wall& wall, const Vector3d& x_out_z, const Vector3d& size, double yaw,
               const BoxTextures& box) {
    const Eigen::Quaterniond q(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
    scene_.AddBox(wall.T_WL * Pose(q, Vector3d(x_out_z.x(), -x_out_z.y(), x_out_z.z())), size, box);
  }

  // A framed print, its middle at (x, z).
  void AddPicture(const Wall& wall, const Vector2d& xz, const Vector2d& size, bool notice) {
    const Vector2d place =
        xz + Vector2d(random_.Uniform(-0.05, 0.05), random_.Uniform(-0.05, 0.05));
    constexpr double kBorder = 0.04;
    const Vector2d outer = size.array() + 2 * kBorder;
    const int frame = random_.Index(2) == 0 ? wood_ : dark_;
    AddOn(wall, {place.x(), place.y() - 0.5 * outer.y()}, {outer.x(), 0.03, outer.y()},
          {frame, frame, frame});
    const int print =
        scene_.AddTexture(notice ? MakeNotice(size, &random_) : MakePoster(size, &random_));
    scene_.AddRectangle(
        wall.T_WL * Vector3d(place.x() - 0.5 * size.x(), -0.032, place.y() - 0.5 * size.y()),
        wall.T_WL.q() * Vector3d(size.x(), 0, 0), {0, 0, size.y()}, print);
  }

  void AddTable(const Wall& wall, double x, const Vector3d& size) {
    constexpr double kTop = 0.035, kLeg = 0.05;
    AddOn(wall, {x, size.z() - kTop}, {size.x(), size.y(), kTop}, {wood_, wood_, wood_});
    for (const double side : {-1.0, 1.0}) {
      for (const double out : {kLeg, size.y() - kLeg}) {
        AddFree(wall, {x + side * (0.5 * size.x() - kLeg), out, 0.0}, {kLeg, kLeg, size.z() - kTop},
                0.0, {metal_, metal_, metal_});
      }
    }
  }

  void AddCardboardBox(const Wall& wall, const Vector3d& x_out_z, const Vector3d& size) {
    const int front = scene_.AddTexture(MakeCardboard({size.x(), size.z()}, &random_));
    const int top = scene_.AddTexture(MakeCardboard({size.x(), size.y()}, &random_));
    AddFree(wall, x_out_z, size, random_.Uniform(-0.35, 0.35), {cardboard_, front, top});
  }

  void AddCupboard(const Wall& wall, double x, const Vector3d& size, int rows, int columns) {
    const Colour colour = 0.6f * RandomColour(&random_) + Colour::Constant(0.25f);
    const int front =
        scene_.AddTexture(MakePanels({size.x(), size.z()}, rows, columns, colour, &random_));
    AddOn(wall, {x, 0.0}, size, {wood_, front, wood_});
  }

  // Boards between two sides, rows of books of different depths on them.
  void AddBookshelf(const Wall& wall, double x, const Vector3d& size, int shelves) {
    constexpr double kBoard = 0.025;
    for (const double side : {-0.5, 0.5}) {
      AddOn(wall, {x + side * (size.x() - kBoard), 0.0}, {kBoard, size.y(), size.z()},
            {wood_, wood_, wood_});
    }
    const double inner = size.x() - 2 * kBoard;
    const double rise = (size.z() - kBoard) / shelves;
    for (int shelf = 0; shelf <= shelves; ++shelf) {
      AddOn(wall, {x, shelf * rise}, {inner, size.y() - 0.01, kBoard}, {wood_, wood_, wood_});
      if (shelf == shelves) break;
      for (double s = -0.5 * inner; s < 0.5 * inner - 0.1;) {
        const double width = std::min(0.5 * inner - s, random_.Uniform(0.2, 0.45));
        const Vector3d row(width, size.y() * random_.Uniform(0.55, 0.9),
                           (rise - kBoard) * random_.Uniform(0.65, 0.92));
        const int spines = scene_.AddTexture(MakeBooks({row.x(), row.z()}, &random_));
        AddOn(wall, {x + s + 0.5 * width, shelf * rise + kBoard}, row, {dark_, spines, white_});
        s += width + random_.Uniform(0.0, 0.12);
      }
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

  RandomSequence random_;
  Scene scene_;
  const Wall bricks_ = MakeWall(0.0, kHalfY, 2 * kHalfX);       // +y
  const Wall desk_ = MakeWall(-0.5 * kPi, kHalfX, 2 * kHalfY);  // +x
  const Wall plaster_ = MakeWall(kPi, kHalfY, 2 * kHalfX);      // -y
  const Wall shelf_ = MakeWall(0.5 * kPi, kHalfX, 2 * kHalfY);  // -x
  int wood_ = 0, dark_ = 0, white_ = 0, metal_ = 0, cardboard_ = 0;
};

// Camera axes (x right, y down, z forward) looking along yaw and pitch [rad], turned by roll.
Eigen::Quaterniond Look(double yaw, double pitch, double roll) {
  const Vector3d z(std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch),
                   std::sin(pitch));
  const Vector3d x = z.cross(Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d R_WC;
  R_WC << x, z.cross(x), z;
  return Eigen::Quaterniond(R_WC) * Eigen::AngleAxisd(roll, Vector3d::UnitZ());
}

}  // namespace

Scene MakeRoom(std::uint64_t seed) {
  return RoomBuilder(seed).Build();
}

SplineTrajectory MakeRoomTrajectory(double duration, std::uint64_t seed, double longest_lap) {
  constexpr double kSpeed = 0.45;        // [m/s]
  constexpr double kShortestLap = 10.0;  // [s]
  constexpr double kKnotInterval = 0.8;  // [s]
  const double period = std::max(kShortestLap, duration / std::ceil(duration / longest_lap));
  const double radius = kSpeed * period / (2 * kPi);
  const Vector2d axes(1.1 * radius, 0.9 * radius);  // the room is longer than wide

  RandomSequence random(Mix(seed));
  const double start = random.Uniform(-kPi, kPi);
  const int knots = static_cast<int>(std::lround(period / kKnotInterval));
  std::vector<Pose> control;
  for (int i = 0; i < knots; ++i) {
    const double azimuth = start + 2 * kPi * i / knots;
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
