#include <highwall/frontend/map/feature_type_mismatch.h>

#include <highwall/internal/number_text.h>

namespace highwall {
namespace {

std::string WithPyramid(const FeatureType& kind) {
  TextWriter words;
  words << kind.name << " in " << kind.pyramid.levels << " levels of " << kind.pyramid.scale_factor;
  return words.str();
}

std::string WithDescriptor(const FeatureType& kind) {
  TextWriter words;
  words << kind.name << " with descriptors of " << kind.columns
        << (kind.descriptor == DescriptorType::kBinary ? " bytes" : " numbers");
  return words.str();
}

std::optional<FeatureTypeMismatch> FindMismatch(const FeatureType& first, const FeatureType& second,
                                                bool with_pyramids) {
  if (first.name != second.name) return FeatureTypeMismatch{first.name, second.name};
  if (first.descriptor != second.descriptor || first.columns != second.columns) {
    return FeatureTypeMismatch{WithDescriptor(first), WithDescriptor(second)};
  }
  const PyramidOptions &a = first.pyramid, &b = second.pyramid;
  if (!with_pyramids || (a.levels == b.levels && a.scale_factor == b.scale_factor)) return {};
  return FeatureTypeMismatch{WithPyramid(first), WithPyramid(second)};
}

}  // namespace

std::optional<FeatureTypeMismatch> FindMismatch(const Map& first, const Map& second) {
  return FindMismatch(first.feature_type(), second.feature_type(),
                      first.knows_feature_type() && second.knows_feature_type());
}

std::optional<FeatureTypeMismatch> FindMismatch(const Map& first, const FeatureType& second) {
  return FindMismatch(first.feature_type(), second, first.knows_feature_type());
}

}  // namespace highwall
