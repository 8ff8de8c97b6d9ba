#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <cstring>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/mapping/dense_mapper.h>
#include <highwall/mapping/keyframe_cloud.h>
#include <highwall/mapping/occupancy_grid.h>
#include <highwall/mapping/octomap_builder.h>
#include <highwall/mapping/octree_queries.h>
#include <highwall/mapping/point_cloud_io.h>

#include "bindings.h"
#include "images.h"
#include "python_slam.h"
#include "run/depth_camera.h"

namespace highwall::python {
namespace {

using Rows3f = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Rows3 = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Bytes3 = Eigen::Matrix<std::uint8_t, Eigen::Dynamic, 3, Eigen::RowMajor>;

// Separate type: a std::vector would be converted to a list of points.
struct Cloud {
  std::vector<ColoredPoint> points;
};

Eigen::Index Rows(const Cloud& cloud) {
  return static_cast<Eigen::Index>(cloud.points.size());
}
const ColoredPoint& Row(const Cloud& cloud, Eigen::Index i) {
  return cloud.points[static_cast<std::size_t>(i)];
}

Cloud MakeCloud(const Rows3f& points, const py::object& colours) {
  std::optional<Bytes3> rgb;
  if (!colours.is_none()) rgb = BytesOf(colours, "rgb").cast<Bytes3>();
  HIGHWALL_REQUIRE(!rgb || rgb->rows() == points.rows(), "a cloud has a colour for each point");
  Cloud cloud;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    ColoredPoint point{.p = points.row(i)};
    if (rgb) point.rgb = {(*rgb)(i, 0), (*rgb)(i, 1), (*rgb)(i, 2)};
    cloud.points.push_back(point);
  }
  return cloud;
}

void BindCloud(py::module_& module) {
  py::class_<Cloud>(module, "PointCloud", "Points of surfaces, as arrays.")
      .def(py::init(&MakeCloud), py::arg("points"), py::arg("rgb") = py::none(),
           "points: n x 3 [m]. rgb: n x 3 of uint8.")
      .def_static(
          "read_ply", [](const py::object& path) { return Cloud{ReadPly(Path(path))}; },
          py::arg("path"))
      .def(
          "write_ply",
          [](const Cloud& cloud, const py::object& path) { WritePly(Path(path), cloud.points); },
          py::arg("path"))
      .def("__len__", [](const Cloud& cloud) { return cloud.points.size(); })
      .def_property_readonly(
          "points",
          [](const Cloud& cloud) {
            Rows3f rows(Rows(cloud), 3);
            for (Eigen::Index i = 0; i < rows.rows(); ++i) {
              rows.row(i) = Row(cloud, i).p;
            }
            return rows;
          },
          "[m] n x 3, float32")
      .def_property_readonly(
          "rgb",
          [](const Cloud& cloud) {
            Bytes3 rows(Rows(cloud), 3);
            for (Eigen::Index i = 0; i < rows.rows(); ++i) {
              const auto& rgb = Row(cloud, i).rgb;
              rows.row(i) << rgb[0], rgb[1], rgb[2];
            }
            return rows;
          },
          "n x 3, uint8")
      .def_property_readonly(
          "normals",
          [](const Cloud& cloud) {
            Rows3f rows(Rows(cloud), 3);
            for (Eigen::Index i = 0; i < rows.rows(); ++i) {
              rows.row(i) = Row(cloud, i).normal;
            }
            return rows;
          },
          "n x 3, float32; 0 where unknown");
  py::class_<KeyframeCloudOptions> options(module, "KeyframeCloudOptions",
                                           "Of make_keyframe_cloud().");
  KeywordConstructor<KeyframeCloudOptions>(options);
  options.def_readwrite("min_depth", &KeyframeCloudOptions::min_depth, "[m]")
      .def_readwrite("max_depth", &KeyframeCloudOptions::max_depth, "[m]")
      .def_readwrite("stride", &KeyframeCloudOptions::stride, "[px]")
      .def_readwrite("edge_rejection", &KeyframeCloudOptions::edge_rejection)
      .def_readwrite("max_incidence", &KeyframeCloudOptions::max_incidence, "[deg]")
      .def_readwrite("voxel_size", &KeyframeCloudOptions::voxel_size, "[m]");
  module.def(
      "make_keyframe_cloud",
      [](const py::object& depth, const py::object& bgr, const PinholeCamera& camera,
         const KeyframeCloudOptions& cloud_options) {
        return Cloud{MakeKeyframeCloud(DepthImage(depth), ColourImage(bgr), camera, cloud_options)};
      },
      py::arg("depth"), py::arg("bgr"), py::arg("camera"),
      py::arg("options") = KeyframeCloudOptions{}, "The points of an image, in its frame C.");
}

py::tuple Leaves(const OctomapBuilder& octree) {
  std::vector<OctreeLeaf> leaves;
  octree.ForEachLeaf([&](const OctreeLeaf& leaf) { leaves.push_back(leaf); });
  const auto n = static_cast<Eigen::Index>(leaves.size());
  Rows3 centres(n, 3);
  Eigen::VectorXd sizes(n);
  Eigen::VectorXf log_odds(n);
  Eigen::Array<bool, Eigen::Dynamic, 1> occupied(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const OctreeLeaf& leaf = leaves[static_cast<std::size_t>(i)];
    centres.row(i) = leaf.center_W;
    sizes[i] = leaf.size;
    log_odds[i] = leaf.log_odds;
    occupied[i] = leaf.occupied;
  }
  return py::make_tuple(centres, sizes, log_odds, occupied);
}

void BindOctree(py::module_& module) {
  py::class_<OctomapBuilderOptions> options(module, "OctomapBuilderOptions",
                                            "Of an OctomapBuilder.");
  KeywordConstructor<OctomapBuilderOptions>(options);
  options.def_readwrite("resolution", &OctomapBuilderOptions::resolution, "[m]")
      .def_readwrite("min_depth", &OctomapBuilderOptions::min_depth, "[m]")
      .def_readwrite("max_range", &OctomapBuilderOptions::max_range, "[m]")
      .def_readwrite("hit", &OctomapBuilderOptions::hit)
      .def_readwrite("miss", &OctomapBuilderOptions::miss)
      .def_readwrite("occupancy_threshold", &OctomapBuilderOptions::occupancy_threshold)
      .def_readwrite("threads", &OctomapBuilderOptions::threads);
  py::class_<OctomapBuilder>(module, "OctomapBuilder",
                             "An octree of occupied and free space, as OctoMap builds it.")
      .def(py::init<const OctomapBuilderOptions&>(), py::arg("options") = OctomapBuilderOptions{})
      .def(
          "insert",
          [](OctomapBuilder& octree, const py::object& depth, const PinholeCamera& camera,
             const Pose& T_WC) { octree.Insert(DepthImage(depth), camera, T_WC); },
          py::arg("depth"), py::arg("camera"), py::arg("T_WC"))
      .def(
          "insert_points",
          [](OctomapBuilder& octree, const Rows3f& points, const Pose& T_WC) {
            std::vector<Eigen::Vector3f> points_C;
            for (Eigen::Index i = 0; i < points.rows(); ++i) points_C.emplace_back(points.row(i));
            octree.Insert(points_C, T_WC);
          },
          py::arg("points"), py::arg("T_WC"), "points: n x 3 [m] in the sensor's frame.")
      .def("occupancy", &OctomapBuilder::Occupancy, py::arg("p_W"),
           "Probability at a point [m]; None where nothing is known.")
      .def("is_occupied", &OctomapBuilder::IsOccupied, py::arg("p_W"))
      .def("leaves", &Leaves,
           "(centres n x 3 [m], edges [m], log odds, occupied): one of each a leaf.")
      .def(
          "cast_ray",
          [](const OctomapBuilder& octree, const Eigen::Vector3d& origin,
             const Eigen::Vector3d& direction, double max_range, bool through_unknown) {
            const auto hit = CastRay(octree, origin, direction, max_range, through_unknown);
            if (!hit) return py::object(py::none());
            return py::object(py::make_tuple(hit->p_W, hit->distance, hit->known));
          },
          py::arg("origin_W"), py::arg("direction_W"), py::arg("max_range"),
          py::arg("through_unknown") = false,
          "(centre of the voxel [m], distance [m], whether it is known), or None.")
      .def(
          "nearest_obstacle",
          [](const OctomapBuilder& octree, const Eigen::Vector3d& p_W, double max_distance) {
            const auto obstacle = NearestObstacle(octree, p_W, max_distance);
            if (!obstacle) return py::object(py::none());
            return py::object(py::make_tuple(obstacle->p_W, obstacle->distance));
          },
          py::arg("p_W"), py::arg("max_distance"), "(point [m], distance [m]), or None.")
      .def(
          "write",
          [](const OctomapBuilder& octree, const py::object& path) { octree.Write(Path(path)); },
          py::arg("path"), ".ot: log odds.")
      .def(
          "write_binary",
          [](const OctomapBuilder& octree, const py::object& path) {
            octree.WriteBinary(Path(path));
          },
          py::arg("path"), ".bt: occupied or free.")
      .def_static(
          "read", [](const py::object& path) { return OctomapBuilder::Read(Path(path)); },
          py::arg("path"));
}

void BindGrid(py::module_& module) {
  py::class_<OccupancyGrid>(module, "OccupancyGrid", "A 2-D map for planning, z up.")
      .def_readonly("resolution", &OccupancyGrid::resolution, "[m] a cell")
      .def_readonly("origin_G", &OccupancyGrid::origin_G, "[m] corner of cell (0, 0)")
      .def_property_readonly(
          "cells",
          [](const OccupancyGrid& grid) {
            py::array_t<std::uint8_t> cells({grid.height, grid.width});
            std::memcpy(cells.mutable_data(), grid.cells.data(), grid.cells.size());
            return cells;
          },
          "height x width of uint8: 0 unknown, 1 free, 2 occupied; rows along y")
      .def(
          "write",
          [](const OccupancyGrid& grid, const py::object& path) {
            WriteOccupancyGrid(Path(path), grid);
          },
          py::arg("yaml_path"), "And .pgm beside it, as map_server reads them.");
  module.def(
      "project_to_grid",
      [](const OctomapBuilder& octree, double z_min, double z_max, double ground_height) {
        return ProjectToGrid(octree,
                             {.z_min = z_min, .z_max = z_max, .ground_height = ground_height});
      },
      py::arg("octree"), py::arg("z_min") = OccupancyGridOptions{}.z_min,
      py::arg("z_max") = OccupancyGridOptions{}.z_max, py::arg("ground_height") = 0.0,
      "What stands in a band above the ground [m].");
}

DenseMapOptions MapOptions(double voxel_size, double resolution, bool background) {
  DenseMapOptions options;
  options.cloud.voxel_size = voxel_size;
  options.octree.resolution = resolution;
  options.background = background;
  return options;
}

std::shared_ptr<Mapper> MapperOf(const py::object& system, double voxel_size, double resolution,
                                 bool background) {
  auto& slam = system.cast<Slam&>();
  DenseMapOptions options = MapOptions(voxel_size, resolution, background);
  std::shared_ptr<Mapper> mapper;
  slam.Call([&](PythonSlam& followed) {
    apps::LimitToRange(followed.sensor(), &options);
    options.level = followed.has_imu();
    mapper = std::make_shared<Mapper>("DenseMapper", [&](const std::shared_ptr<CallGate>& gate) {
      const py::gil_scoped_acquire lock;
      return FollowedMap(options, apps::DepthCameraOf(followed.sensor()), gate->Keep(system));
    });
    followed.AddMapper(mapper);
  });
  return mapper;
}

std::vector<DenseMap> FinishMaps(Mapper& self) {
  const auto kept = self.Call([](const FollowedMap& map) { return map.system(); });
  const py::object system = kept ? kept->Get() : py::object();
  if (!system) return self.Call([](FollowedMap& map) { return map.Finish(nullptr); });
  // Locks the system's gate before the mapper's, in the same order as track().
  return system.cast<Slam&>().Call([&](const SlamSystem& slam) {
    return self.Enter([&](FollowedMap& map) { return map.Finish(&slam); });
  });
}

void BindDenseMapper(py::module_& module) {
  py::class_<DenseMap>(module, "DenseMap", "Cloud, octree and grid.")
      .def_property_readonly("cloud", [](const DenseMap& map) { return Cloud{map.cloud}; })
      .def_property_readonly(
          "octree", [](DenseMap& map) -> OctomapBuilder& { return map.octree; },
          py::return_value_policy::reference_internal)
      .def_readonly("grid", &DenseMap::grid)
      .def_readonly("ground_height", &DenseMap::ground_height, "[m]");
  py::class_<Mapper, std::shared_ptr<Mapper>>(
      module, "DenseMapper",
      "The dense map of a run: follows its keyframes, on a thread of its own.", Collected<Mapper>())
      .def(py::init([](const PinholeCamera& camera, const DepthNoise& noise, double voxel_size,
                       double resolution, bool background) {
             return std::make_shared<Mapper>("DenseMapper", [&](const auto&) {
               return FollowedMap(MapOptions(voxel_size, resolution, background),
                                  DepthCamera{.pinhole = camera, .sigma = [noise](double z) {
                                                return noise.Sigma(z);
                                              }});
             });
           }),
           py::arg("camera"), py::arg("noise") = DepthNoise{},
           py::arg("voxel_size") = KeyframeCloudOptions{}.voxel_size,
           py::arg("resolution") = OctomapBuilderOptions{}.resolution, py::arg("background") = true,
           "One that is fed by hand: in one layer, with all that was measured. voxel_size: [m] of "
           "the cloud. resolution: [m] of the octree.")
      .def_static(
          "following", &MapperOf, py::arg("slam"),
          py::arg("voxel_size") = KeyframeCloudOptions{}.voxel_size,
          py::arg("resolution") = OctomapBuilderOptions{}.resolution, py::arg("background") = true,
          "Returns a mapper that follows a SlamSystem from its first frame on, as in "
          "`highwall slam`: with corrected depth, without dynamic objects, one map for each "
          "submap.")
      .def(
          "add_keyframe",
          [](Mapper& self, std::int64_t id, Stamp stamp, const py::object& bgr,
             const py::object& depth, const Pose& T_WC) {
            const KeyframeImage keyframe{.id = id,
                                         .stamp = stamp,
                                         .depth = DepthImage(depth),
                                         .bgr = ColourImage(bgr),
                                         .T_WC = T_WC};
            self.Call([&](FollowedMap& map) { map.mapper().AddKeyframe(keyframe); });
          },
          py::arg("id"), py::arg("stamp"), py::arg("bgr"), py::arg("depth"), py::arg("T_WC"))
      .def(
          "set_poses",
          [](Mapper& self, const std::map<std::int64_t, Pose>& poses) {
            std::map<std::int64_t, KeyframePose> placed;
            for (const auto& [id, T_WC] : poses) placed[id] = {.T_WC = T_WC};
            self.Call([&](FollowedMap& map) { map.mapper().SetPoses(std::move(placed)); });
          },
          py::arg("poses"), "{id: T_WC}: all keyframes; the map follows.")
      .def("finish", &FinishMaps,
           "The map of each submap, that of most frames first; of a mapper that is fed by hand one "
           "map. None without keyframes. Call once, last.");
}

}  // namespace

void BindMapping(py::module_& module) {
  BindCloud(module);
  BindOctree(module);
  BindGrid(module);
  BindDenseMapper(module);
}

}  // namespace highwall::python
