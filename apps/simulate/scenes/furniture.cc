#include "simulate/scenes/furniture.h"

#include <algorithm>
#include <memory>

#include <Eigen/Geometry>

#include "simulate/materials/prints.h"

namespace highwall::simulate {

using Eigen::Vector2d;
using Eigen::Vector3d;

Wall MakeWall(double yaw, double distance, double length, const Vector3d& middle) {
  const Eigen::Quaterniond q(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
  return {Pose(q, middle + q * Vector3d(0.0, distance, 0.0)), length};
}

Furnisher::Furnisher(std::uint64_t seed) : random_(seed) {
  MakeMaterials();
}

int Furnisher::AddNoise(const Colour& colour, double contrast, double wavelength, int octaves) {
  return scene_.AddTexture(
      std::make_unique<NoiseTexture>(colour, static_cast<float>(contrast),
                                     ValueNoise{static_cast<float>(wavelength), octaves, Seed()}));
}

int Furnisher::AddMasonry(MasonryOptions options) {
  options.noise.seed = Seed();
  return scene_.AddTexture(std::make_unique<MasonryTexture>(options));
}

void Furnisher::AddWall(const Wall& wall, double height, int texture) {
  scene_.AddRectangle(wall.T_WL * Vector3d(-0.5 * wall.length, 0, 0),
                      wall.T_WL.q() * Vector3d(wall.length, 0, 0), {0, 0, height}, texture);
  AddOn(wall, {0, 0}, {wall.length, 0.02, 0.1}, {dark_, dark_, dark_});
  AddOn(wall, {0, height - 0.08}, {wall.length, 0.03, 0.08}, {white_, white_, white_});
}

void Furnisher::MakeMaterials() {
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

void Furnisher::AddOn(const Wall& wall, const Vector2d& xz, const Vector3d& size,
                      const BoxTextures& box) {
  scene_.AddBox(
      wall.T_WL * Pose(Eigen::Quaterniond::Identity(), Vector3d(xz.x(), -0.5 * size.y(), xz.y())),
      size, box);
}

void Furnisher::AddFree(const Wall& wall, const Vector3d& x_out_z, const Vector3d& size, double yaw,
                        const BoxTextures& box) {
  const Eigen::Quaterniond q(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
  scene_.AddBox(wall.T_WL * Pose(q, Vector3d(x_out_z.x(), -x_out_z.y(), x_out_z.z())), size, box);
}

void Furnisher::AddPicture(const Wall& wall, const Vector2d& xz, const Vector2d& size,
                           bool notice) {
  const Vector2d place = xz + Vector2d(random_.Uniform(-0.05, 0.05), random_.Uniform(-0.05, 0.05));
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

void Furnisher::AddTable(const Wall& wall, double x, const Vector3d& size) {
  constexpr double kTop = 0.035, kLeg = 0.05;
  AddOn(wall, {x, size.z() - kTop}, {size.x(), size.y(), kTop}, {wood_, wood_, wood_});
  for (const double side : {-1.0, 1.0}) {
    for (const double out : {kLeg, size.y() - kLeg}) {
      AddFree(wall, {x + side * (0.5 * size.x() - kLeg), out, 0.0}, {kLeg, kLeg, size.z() - kTop},
              0.0, {metal_, metal_, metal_});
    }
  }
}

void Furnisher::AddCardboardBox(const Wall& wall, const Vector3d& x_out_z, const Vector3d& size) {
  const int front = scene_.AddTexture(MakeCardboard({size.x(), size.z()}, &random_));
  const int top = scene_.AddTexture(MakeCardboard({size.x(), size.y()}, &random_));
  AddFree(wall, x_out_z, size, random_.Uniform(-0.35, 0.35), {cardboard_, front, top});
}

void Furnisher::AddCupboard(const Wall& wall, double x, const Vector3d& size, int rows,
                            int columns) {
  const Colour colour = 0.6f * RandomColour(&random_) + Colour::Constant(0.25f);
  const int front =
      scene_.AddTexture(MakePanels({size.x(), size.z()}, rows, columns, colour, &random_));
  AddOn(wall, {x, 0.0}, size, {wood_, front, wood_});
}

void Furnisher::AddBookshelf(const Wall& wall, double x, const Vector3d& size, int shelves) {
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

}  // namespace highwall::simulate
