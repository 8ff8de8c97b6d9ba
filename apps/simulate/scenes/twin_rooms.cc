#include "simulate/scenes/twin_rooms.h"

#include <array>
#include <cstddef>
#include <numbers>
#include <utility>

#include "simulate/materials/prints.h"
#include "simulate/random.h"
#include "simulate/scenes/furniture.h"

namespace highwall::simulate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

using std::numbers::pi;
constexpr double kWallHeight = 2.8;  // [m]
constexpr double kApart = 30.0;      // [m]
constexpr double kPassage = 0.5;     // [m] free space in the corners
constexpr double kPictures = 1.62;   // [m] height of their centres, above all furniture

// Widths of the models [m]; see TwinRoomsBuilder::AddModel().
constexpr std::array kWidths = {1.0, 0.6, 0.8, 1.1, 0.5, 0.9};
constexpr std::array<std::array<double, 2>, 4> kPrints = {
    {{0.6, 0.45}, {0.4, 0.6}, {0.5, 0.5}, {0.3, 0.42}}};

class TwinRoomsBuilder : private Furnisher {
 public:
  explicit TwinRoomsBuilder(std::uint64_t seed)
      : Furnisher(Mix(seed)), catalogue_(Mix(seed) + 1), arrangement_(Mix(seed) + 2) {}

  TwinRooms Build() {
    const Vector2d half(arrangement_.Uniform(2.5, 3.0), arrangement_.Uniform(2.1, 2.5));
    const auto other = [&](double length) {
      return length + (arrangement_.Index(2) == 0 ? -1 : 1) * arrangement_.Uniform(0.1, 0.3);
    };
    const Vector2d other_half(other(half.x()), other(half.y()));
    const int paper = arrangement_.Index(3);
    TwinRooms twins{{{{Vector3d::Zero(), half}, {Vector3d(kApart, 0, 0), other_half}}}, {}};
    for (const TwinRooms::Room& room : twins.rooms) {
      BuildShell(room);
      for (int side = 0; side < 4; ++side) {
        const bool along_x = side % 2 == 0;
        const Wall wall = MakeWall(0.5 * pi * side, along_x ? room.half.y() : room.half.x(),
                                   2.0 * (along_x ? room.half.x() : room.half.y()), room.middle);
        Furnish(wall, paper);
      }
    }
    twins.scene = std::move(scene_);
    return twins;
  }

 private:
  void BuildShell(const TwinRooms::Room& room) {
    random_ = RandomSequence(arrangement_.Bits());  // different grain
    const int floor = AddMasonry({.cell = {0.5f, 0.5f},
                                  .joint = 0.008f,
                                  .shift = 0.0f,
                                  .checker = true,
                                  .first = Rgb(0.66, 0.66, 0.6),
                                  .second = Rgb(0.42, 0.38, 0.34),
                                  .joint_colour = Rgb(0.2, 0.2, 0.2),
                                  .contrast = 0.35f,
                                  .noise = {.wavelength = 0.12f, .octaves = 4}});
    const int ceiling = AddNoise(Rgb(0.8, 0.8, 0.78), 0.1, 0.1, 4);
    const Vector3d corner = room.middle - Vector3d(room.half.x(), room.half.y(), 0.0);
    const Vector3d x(2.0 * room.half.x(), 0, 0), y(0, 2.0 * room.half.y(), 0), z(0, 0, kWallHeight);
    scene_.AddRectangle(corner, x, y, floor);
    scene_.AddRectangle(corner + y + z, x, -y, ceiling);
    for (const Vector2d& share : {Vector2d(-0.5, -0.4), Vector2d(0.5, -0.4), Vector2d(0.0, 0.5)}) {
      const Vector2d xy = room.half.cwiseProduct(share);
      scene_.lights.push_back({room.middle + Vector3d(xy.x(), xy.y(), kWallHeight - 0.2), 1.9});
    }
  }

  // Same material in both rooms.
  int AddPaper(int paper) {
    if (paper == 0) return AddNoise(Rgb(0.72, 0.74, 0.66), 0.14, 0.25, 6);
    if (paper == 1) return AddMasonry({.contrast = 0.5f, .noise = {.wavelength = 0.06f}});
    return AddMasonry({.cell = {0.24f, 4.0f},
                       .joint = 0.012f,
                       .shift = 0.0f,
                       .checker = true,
                       .first = Rgb(0.5, 0.6, 0.62),
                       .second = Rgb(0.62, 0.7, 0.7),
                       .joint_colour = Rgb(0.85, 0.82, 0.7),
                       .contrast = 0.18f,
                       .noise = {.wavelength = 0.08f, .octaves = 4}});
  }

  // Places models next to each other along the foot of the wall, and pictures above.
  void Furnish(const Wall& wall, int paper) {
    random_ = RandomSequence(arrangement_.Bits());
    AddWall(wall, kWallHeight, AddPaper(paper));
    const double end = 0.5 * wall.length - kPassage;
    // Random starts: otherwise a corner with its furniture would be one object identical in both
    // rooms.
    for (double x = arrangement_.Uniform(0.0, 0.5) - end;; x += arrangement_.Uniform(0.08, 0.5)) {
      const int model = arrangement_.Index(static_cast<int>(kWidths.size()));
      const double width = kWidths[static_cast<std::size_t>(model)];
      if (x + width > end) break;
      AddModel(wall, x + 0.5 * width, model);
      x += width;
    }
    for (double x = arrangement_.Uniform(0.0, 0.5) - end;; x += arrangement_.Uniform(0.12, 0.6)) {
      const int print = arrangement_.Index(static_cast<int>(kPrints.size()));
      const auto [width, height] = kPrints[static_cast<std::size_t>(print)];
      if (x + width > end) break;
      random_ = RandomSequence(catalogue_ + 100 + static_cast<std::uint64_t>(print));
      AddPicture(wall, {x + 0.5 * width, kPictures + arrangement_.Uniform(-0.12, 0.2)},
                 {width, height}, print == 3);
      x += width;
    }
  }

  // Adds a model of the catalogue, identical on every call.
  void AddModel(const Wall& wall, double x, int model) {
    random_ = RandomSequence(catalogue_ + static_cast<std::uint64_t>(model));
    switch (model) {
      case 0:
        AddCupboard(wall, x, {1.0, 0.42, 0.8}, 2, 3);
        return;
      case 1:
        AddCupboard(wall, x, {0.6, 0.4, 1.15}, 4, 1);
        return;
      case 2:
        AddBookshelf(wall, x, {0.8, 0.3, 1.1}, 4);
        return;
      case 3: {
        AddTable(wall, x, {1.1, 0.6, 0.72});
        const int screen = scene_.AddTexture(MakeScreen({0.5, 0.32}, &random_));
        AddFree(wall, {x + 0.15, 0.3, 0.72}, {0.5, 0.05, 0.36}, 0.15, {dark_, screen, dark_});
        AddCardboardBox(wall, {x - 0.35, 0.3, 0.72}, {0.26, 0.24, 0.2});
        return;
      }
      case 4:
        AddCardboardBox(wall, {x, 0.3, 0.0}, {0.45, 0.4, 0.42});
        AddCardboardBox(wall, {x, 0.3, 0.42}, {0.32, 0.3, 0.26});
        return;
      default:
        AddCupboard(wall, x, {0.9, 0.35, 0.62}, 3, 2);
        AddCardboardBox(wall, {x - 0.2, 0.18, 0.62}, {0.36, 0.26, 0.3});
        return;
    }
  }

  std::uint64_t catalogue_;
  RandomSequence arrangement_;
};

}  // namespace

TwinRooms MakeTwinRooms(std::uint64_t seed) {
  return TwinRoomsBuilder(seed).Build();
}

}  // namespace highwall::simulate
