#include "simulate/raycaster.h"

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>

#if HIGHWALL_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace highwall::simulate {
namespace {

void Intersect(RTCScene scene, RTCRayHit* query) {
#if HIGHWALL_EMBREE_MAJOR >= 4
  rtcIntersect1(scene, query);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, query);
#endif
}

void FillGeometry(RTCGeometry geometry, const Mesh& mesh) {
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.vertices.size()));
  auto* indices = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(std::uint32_t), mesh.triangles.size()));
  if (vertices == nullptr || indices == nullptr) return;  // reported by the device
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    for (int i = 0; i < 3; ++i) *vertices++ = static_cast<float>(vertex[i]);
  }
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t index : triangle) *indices++ = index;
  }
}

}  // namespace

struct Raycaster::Tree {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  ~Tree() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }
};

Raycaster::Raycaster(const Mesh& mesh) : tree_(std::make_unique<Tree>()) {
  tree_->device = rtcNewDevice(nullptr);
  if (tree_->device == nullptr) throw std::runtime_error("Raycaster: no Embree device");
  tree_->scene = rtcNewScene(tree_->device);
  // Robust: no ray may slip through the seam of two triangles.
  rtcSetSceneFlags(tree_->scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(tree_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  FillGeometry(geometry, mesh);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(tree_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(tree_->scene);
  if (const RTCError error = rtcGetDeviceError(tree_->device); error != RTC_ERROR_NONE) {
    throw std::runtime_error("Raycaster: Embree error " + std::to_string(error));
  }
}

Raycaster::~Raycaster() = default;
Raycaster::Raycaster(Raycaster&&) noexcept = default;
Raycaster& Raycaster::operator=(Raycaster&&) noexcept = default;

int Raycaster::FirstTriangle(const Eigen::Vector3d& origin,
                             const Eigen::Vector3d& direction) const {
  RTCRayHit query{};
  query.ray.org_x = static_cast<float>(origin.x());
  query.ray.org_y = static_cast<float>(origin.y());
  query.ray.org_z = static_cast<float>(origin.z());
  query.ray.dir_x = static_cast<float>(direction.x());
  query.ray.dir_y = static_cast<float>(direction.y());
  query.ray.dir_z = static_cast<float>(direction.z());
  query.ray.tfar = std::numeric_limits<float>::infinity();
  query.ray.mask = ~0u;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  Intersect(tree_->scene, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return kNone;
  return static_cast<int>(query.hit.primID);
}

}  // namespace highwall::simulate
