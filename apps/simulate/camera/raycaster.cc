#include "simulate/camera/raycaster.h"

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

#if HIGHWALL_EMBREE_MAJOR >= 4
void Intersect(RTCScene scene, RTCRayHit* query) {
  rtcIntersect1(scene, query);
}

void Intersect(RTCScene scene, const int* valid, RTCRayHit8* query) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect8(valid, scene, query, &arguments);
}

void Occlude(RTCScene scene, RTCRay* query) {
  rtcOccluded1(scene, query);
}
#else
void Intersect(RTCScene scene, RTCRayHit* query) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, query);
}

void Intersect(RTCScene scene, const int* valid, RTCRayHit8* query) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect8(valid, scene, &context, query);
}

void Occlude(RTCScene scene, RTCRay* query) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, query);
}
#endif

RTCRay MakeRay(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  RTCRay ray{};
  ray.org_x = static_cast<float>(origin.x());
  ray.org_y = static_cast<float>(origin.y());
  ray.org_z = static_cast<float>(origin.z());
  ray.dir_x = static_cast<float>(direction.x());
  ray.dir_y = static_cast<float>(direction.y());
  ray.dir_z = static_cast<float>(direction.z());
  ray.tfar = std::numeric_limits<float>::infinity();
  ray.mask = ~0u;
  return ray;
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
  query.ray = MakeRay(origin, direction);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  Intersect(tree_->scene, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return kNone;
  return static_cast<int>(query.hit.primID);
}

std::array<int, Raycaster::kPacket> Raycaster::FirstTriangles(
    const Eigen::Vector3d& origin, const std::array<Eigen::Vector3d, kPacket>& directions) const {
  alignas(32) constexpr std::array<int, kPacket> kAll = {-1, -1, -1, -1, -1, -1, -1, -1};
  RTCRayHit8 query{};
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const RTCRay ray = MakeRay(origin, directions[i]);
    query.ray.org_x[i] = ray.org_x;
    query.ray.org_y[i] = ray.org_y;
    query.ray.org_z[i] = ray.org_z;
    query.ray.dir_x[i] = ray.dir_x;
    query.ray.dir_y[i] = ray.dir_y;
    query.ray.dir_z[i] = ray.dir_z;
    query.ray.tfar[i] = ray.tfar;
    query.ray.mask[i] = ray.mask;
    query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
  }
  Intersect(tree_->scene, kAll.data(), &query);
  std::array<int, kPacket> triangles{};
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    triangles[i] = query.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID
                       ? kNone
                       : static_cast<int>(query.hit.primID[i]);
  }
  return triangles;
}

bool Raycaster::IsFree(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                       double reach) const {
  RTCRay query = MakeRay(origin, direction);
  query.tfar = static_cast<float>(reach);
  Occlude(tree_->scene, &query);
  return query.tfar >= 0.0f;  // Embree sets -infinity where something was hit
}

}  // namespace highwall::simulate
