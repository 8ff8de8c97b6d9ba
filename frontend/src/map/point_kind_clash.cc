#include <highwall/frontend/map/point_kind_clash.h>

#include <highwall/internal/number_text.h>

namespace highwall {
namespace {

std::string WithPyramid(const PointKind& kind) {
  TextWriter words;
  words << kind.name << " in " << kind.pyramid.levels << " levels of " << kind.pyramid.scale_factor;
  return words.str();
}

std::string WithDescriptor(const PointKind& kind) {
  TextWriter words;
  words << kind.name << " with descriptors of " << kind.columns
        << (kind.descriptor == DescriptorType::kBinary ? " bytes" : " numbers");
  return words.str();
}

std::optional<PointKindClash> FindClash(const PointKind& first, const PointKind& second,
                                        bool with_pyramids) {
  if (first.name != second.name) return PointKindClash{first.name, second.name};
  if (first.descriptor != second.descriptor || first.columns != second.columns) {
    return PointKindClash{WithDescriptor(first), WithDescriptor(second)};
  }
  const PyramidOptions &a = first.pyramid, &b = second.pyramid;
  if (!with_pyramids || (a.levels == b.levels && a.scale_factor == b.scale_factor)) return {};
  return PointKindClash{WithPyramid(first), WithPyramid(second)};
}

}  // namespace

std::optional<PointKindClash> FindClash(const Map& first, const Map& second) {
  return FindClash(first.point_kind(), second.point_kind(),
                   first.knows_point_kind() && second.knows_point_kind());
}

std::optional<PointKindClash> FindClash(const Map& first, const PointKind& second) {
  return FindClash(first.point_kind(), second, first.knows_point_kind());
}

}  // namespace highwall
