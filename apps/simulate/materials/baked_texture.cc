#include "simulate/materials/baked_texture.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <utility>

#include "simulate/materials/lattice_noise.h"

namespace highwall::simulate {
namespace {

constexpr int kLevels = 6;
constexpr int kTile = 32;           // [texels]
constexpr int kStride = kTile + 1;  // includes the first texels of the next tile, for interpolation
constexpr float kMaxValue = 255.0f;

// Blue, green and red in bits 0, 8 and 16.
using Texel = std::uint32_t;

// Spreads the colours to 16 bits each, with room for weights of 8 bits: all are mixed in one
// operation.
std::uint64_t Spread(Texel texel) {
  std::uint64_t x = texel;
  x = (x | x << 16) & 0x0000ffff0000ffff;
  return (x | x << 8) & 0x00ff00ff00ff00ff;
}

}  // namespace

struct BakedTexture::Tile {
  mutable std::once_flag once;
  mutable std::atomic<bool> ready = false;
  std::vector<Texel> texels;  // kStride x kStride, row by row
};

struct BakedTexture::Level {
  Eigen::Vector2f texel;  // [m]
  Eigen::Vector2i tiles;  // columns, rows
  std::unique_ptr<Tile[]> tile;
};

BakedTexture::BakedTexture(std::unique_ptr<const Texture> source, const Eigen::Vector2f& min,
                           const Eigen::Vector2f& size, float texel)
    : source_(std::move(source)), min_(min) {
  // The coarsest level consists of whole tiles, hence all levels do.
  const Eigen::Vector2f coarsest =
      (size / (texel * (kTile << (kLevels - 1)))).array().round().max(1.0f);
  for (int i = 0; i < kLevels; ++i) {
    const Eigen::Vector2i tiles = coarsest.cast<int>() * (1 << (kLevels - 1 - i));
    const auto count = static_cast<std::size_t>(tiles.x()) * static_cast<std::size_t>(tiles.y());
    levels_.push_back(
        {size.cwiseQuotient(tiles.cast<float>() * kTile), tiles, std::make_unique<Tile[]>(count)});
  }
}

BakedTexture::~BakedTexture() = default;

const BakedTexture::Tile& BakedTexture::Fetch(const Level& level, int column, int row) const {
  Tile& tile =
      level.tile[static_cast<std::size_t>(row) * static_cast<std::size_t>(level.tiles.x()) +
                 static_cast<std::size_t>(column)];
  if (!tile.ready.load(std::memory_order_acquire)) {
    std::call_once(tile.once, [&] {
      Fill(level, column, row, &tile);
      tile.ready.store(true, std::memory_order_release);
    });
  }
  return tile;
}

void BakedTexture::Fill(const Level& level, int column, int row, Tile* tile) const {
  // Coarse texels average 2 x 2 lookups, because the source's own filter is approximate.
  const int grid = &level == levels_.data() ? 1 : 2;
  const float footprint = level.texel.maxCoeff() / static_cast<float>(grid);
  const Eigen::Vector2i columns_rows = level.tiles * kTile;
  tile->texels.reserve(kStride * kStride);
  for (int j = 0; j < kStride; ++j) {
    for (int i = 0; i < kStride; ++i) {
      const Eigen::Vector2f corner(static_cast<float>((column * kTile + i) % columns_rows.x()),
                                   static_cast<float>((row * kTile + j) % columns_rows.y()));
      Colour sum = Colour::Zero();
      for (int k = 0; k < grid * grid; ++k) {
        const Eigen::Vector2f in_texel =
            (Eigen::Vector2f(static_cast<float>(k % grid), static_cast<float>(k / grid)).array() +
             0.5f) /
            static_cast<float>(grid);
        sum += source_->Albedo(min_ + (corner + in_texel).cwiseProduct(level.texel), footprint);
      }
      const Eigen::Array3f value = sum.array() * (kMaxValue / static_cast<float>(grid * grid));
      const auto bytes = (value + 0.5f).min(kMaxValue).max(0.0f).cast<std::uint8_t>().eval();
      tile->texels.push_back(static_cast<Texel>(bytes[0] | bytes[1] << 8 | bytes[2] << 16));
    }
  }
}

Colour BakedTexture::Lookup(const Level& level, const Eigen::Vector2f& st) const {
  const float x = (st.x() - min_.x()) / level.texel.x() - 0.5f;
  const float y = (st.y() - min_.y()) / level.texel.y() - 0.5f;
  const int i = Floor(x), j = Floor(y);
  constexpr int kOne = 256;  // of weights
  const int a = static_cast<int>((x - static_cast<float>(i)) * kOne);
  const int b = static_cast<int>((y - static_cast<float>(j)) * kOne);
  const int ab = a * b / kOne;
  const int column = Wrap(i, level.tiles.x() * kTile), row = Wrap(j, level.tiles.y() * kTile);
  const Tile& tile = Fetch(level, column / kTile, row / kTile);
  const Texel* texel =
      &tile.texels[static_cast<std::size_t>(row % kTile * kStride + column % kTile)];
  const auto weighted = [](int weight, Texel t) {
    return static_cast<std::uint64_t>(weight) * Spread(t);
  };
  const std::uint64_t sum = weighted(kOne - a - b + ab, texel[0]) + weighted(a - ab, texel[1]) +
                            weighted(b - ab, texel[kStride]) + weighted(ab, texel[kStride + 1]);
  const auto channel = [sum](int k) { return static_cast<float>(sum >> (16 * k) & 0xffff); };
  return Colour(channel(0), channel(1), channel(2)) / (kMaxValue * kOne);
}

Colour BakedTexture::Albedo(const Eigen::Vector2f& st, float footprint) const {
  float texel = levels_.front().texel.maxCoeff();
  std::size_t fine = 0;
  for (; fine + 2 < levels_.size() && footprint > 2.0f * texel; ++fine) texel *= 2.0f;
  const float coarser = std::clamp(footprint / texel - 1.0f, 0.0f, 1.0f);
  const Colour colour = Lookup(levels_[fine], st);
  if (coarser == 0.0f) return colour;
  return colour + (Lookup(levels_[fine + 1], st) - colour) * coarser;
}

}  // namespace highwall::simulate
