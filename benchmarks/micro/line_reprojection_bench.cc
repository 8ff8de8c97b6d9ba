#include <memory>

#include <highwall/core/line3.h>
#include <highwall/factors/line_reprojection.h>

#include "evaluate_bench.h"
#include "support/reprojection_twins.h"

namespace highwall::line_reprojection_bench {
namespace {

const bool registered = [] {
  const twins::Rig rig{PinholeCamera(), Pose::FromTangent({0.05, 0.0, 0.1}, {0.3, -0.5, 0.2}),
                       VirtualRightCamera()};
  const RgbdProjection projection(rig.camera, rig.T_BC, rig.right);
  const Pose T_WB = Pose::FromTangent({1.0, 2.0, 0.5}, {0.4, 1.0, -0.7});
  const Segment3 segment = T_WB * (rig.T_BC * Segment3({0.3, -0.2, 2.0}, {-0.3, 0.1, 2.6}));
  const OrthonormalLine line(PluckerLine::FromPoints(segment.p(), segment.q()));
  const std::vector<double> pose(T_WB.data(), T_WB.data() + Pose::kSize);
  const std::vector<std::vector<double>> ends = {
      pose, {segment.data(), segment.data() + Segment3::kSize}};
  const std::vector<std::vector<double>> orthonormal = {
      pose, {line.data(), line.data() + OrthonormalLine::kSize}};

  const RgbdSegment z{{400.0, 180.0, 20.0}, {260.0, 262.0, 16.0}};
  const Eigen::Vector2d s = z.s.head<2>(), e = z.e.head<2>();
  const SegmentNoise noise;
  RegisterEvaluate("LineReprojection",
                   std::make_shared<LineReprojection>(SegmentRows(s, e, noise.px), projection),
                   MakeLine(twins::Segment{rig, z, noise, {}, false}), ends);
  RegisterEvaluate("OrthonormalLineReprojection",
                   std::make_shared<OrthonormalLineReprojection>(s, e, noise.px, projection),
                   MakeLine(twins::OrthonormalLine{rig, z, noise, {}, false}), orthonormal);
  for (const Weighting weighting : {Weighting::kCovariance, Weighting::kPaper}) {
    const std::string suffix = std::string("/") + ToString(weighting);
    RegisterEvaluate(
        "LineReprojectionRgbd" + suffix,
        std::make_shared<LineReprojectionRgbd>(SegmentRows(z, noise, weighting), projection),
        MakeLine(twins::Segment{rig, z, noise, weighting}), ends);
    RegisterEvaluate(
        "OrthonormalLineReprojectionRgbd" + suffix,
        std::make_shared<OrthonormalLineReprojectionRgbd>(z, noise, weighting, projection),
        MakeLine(twins::OrthonormalLine{rig, z, noise, weighting}), orthonormal);
  }
  return true;
}();

}  // namespace
}  // namespace highwall::line_reprojection_bench
