#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <highwall/frontend/input/open_dataset.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/input/tum_dataset.h>
#include <highwall/frontend/system/slam_system.h>

#include "bindings.h"
#include "images.h"
#include "imu_samples.h"
#include "point_extractor.h"
#include "python_slam.h"
#include "trajectory.h"
#include "user_factors.h"

namespace highwall::python {
namespace {

RgbdImage MakeImage(Stamp stamp, const py::object& bgr, const py::object& depth) {
  return {.stamp = stamp, .bgr = ColourImage(bgr), .depth = DepthImage(depth)};
}

// Calls a Python function from C++ with the GIL, or does nothing if the collector has freed it.
// Copies share one reference, so that reference counts never change without the GIL.
class Callback {
 public:
  Callback(const CallGate& gate, py::function function)
      : function_(gate.Keep(std::move(function))) {}

  template <class... Arguments>
  void operator()(Arguments&&... arguments) const {
    const py::object function = function_->Get();
    if (function) function(std::forward<Arguments>(arguments)...);
  }

 private:
  std::shared_ptr<Reference> function_;
};

// Releases the GIL, which factors written in Python need on the threads that the system joins.
struct UnlockedDelete {
  void operator()(Slam* slam) const {
    const py::gil_scoped_release unlocked;
    delete slam;
  }
};

using OptionalFunction = std::optional<py::function>;

SlamCallbacks MakeCallbacks(const CallGate& gate, const OptionalFunction& on_keyframe,
                            const OptionalFunction& on_loop, const OptionalFunction& on_map,
                            const OptionalFunction& on_finding, const OptionalFunction& on_frame) {
  SlamCallbacks callbacks;
  if (on_keyframe) {
    callbacks.on_keyframe = [call = Callback(gate, *on_keyframe)](const KeyFrame& keyframe,
                                                                  const RgbdImage& image) {
      const py::gil_scoped_acquire lock;
      call(keyframe.id.value(), keyframe.T_WC, image.stamp, ImageArray(image.bgr),
           ImageArray(image.depth));
    };
  }
  if (on_loop) {
    callbacks.on_loop = [call = Callback(gate, *on_loop)](const LoopReport& loop) {
      const py::gil_scoped_acquire lock;
      call(loop.loop.edge.match.value(), loop.loop.edge.keyframe.value(), loop.accepted,
           loop.message);
    };
  }
  if (on_map) {
    callbacks.on_map = [call = Callback(gate, *on_map)](const Map& map) {
      const py::gil_scoped_acquire lock;
      py::dict poses;
      for (const KeyFrameId id : map.keyframe_ids()) {
        poses[py::int_(id.value())] = map.keyframe(id)->T_WC;
      }
      call(poses);
    };
  }
  if (on_finding) {
    callbacks.on_finding = [call = Callback(gate, *on_finding)](const SensorFinding& finding) {
      const py::gil_scoped_acquire lock;
      call(finding);
    };
  }
  if (on_frame) {
    callbacks.on_frame = [call = Callback(gate, *on_frame)](const FrameResult& frame) {
      const py::gil_scoped_acquire lock;
      call(frame);
    };
  }
  return callbacks;
}

void BindSensor(py::module_& module) {
  py::enum_<ReadoutDirection>(module, "ReadoutDirection", "Where the read-out of images goes.")
      .value("DOWN", ReadoutDirection::kDown)
      .value("UP", ReadoutDirection::kUp)
      .value("RIGHT", ReadoutDirection::kRight)
      .value("LEFT", ReadoutDirection::kLeft);
  py::class_<FrameTiming> timing(module, "FrameTiming", "When the rows of images are taken [s].");
  KeywordConstructor<FrameTiming>(timing);
  timing.def_readwrite("colour_readout", &FrameTiming::colour_readout, "From first row to last.")
      .def_readwrite("depth_readout", &FrameTiming::depth_readout, "From first row to last.")
      .def_readwrite("depth_delay", &FrameTiming::depth_delay,
                     "By which depth is later than the stamps say.")
      .def_readwrite("direction", &FrameTiming::direction, "From the first row to the last.");
  py::class_<RgbdSensor> sensor(module, "RgbdSensor",
                                "An RGB-D camera whose depth is registered to its colour.");
  KeywordConstructor<RgbdSensor>(sensor);
  sensor.def_readwrite("camera", &RgbdSensor::camera)
      .def_readwrite("depth_factor", &RgbdSensor::depth_factor, "Stored value of one metre.")
      .def_readwrite("inverse_depth_offset", &RgbdSensor::inverse_depth_offset,
                     "[1/m] By how much the inverse of a reading is too large.")
      .def_property(
          "depth_pattern", [](const RgbdSensor& self) { return self.depth_pattern.nodes; },
          [](RgbdSensor& self, const DepthPattern::Vector& nodes) {
            self.depth_pattern.nodes = nodes;
          },
          "[1/m] And over the image, at four rows of five nodes, row by row: a copy.")
      .def_readwrite("depth_noise", &RgbdSensor::depth_noise)
      .def_readwrite("min_depth", &RgbdSensor::min_depth, "[m]")
      .def_readwrite("max_depth", &RgbdSensor::max_depth, "[m]")
      .def_readwrite("timing", &RgbdSensor::timing, "Where it is known.")
      .def_static("preset", &SensorPreset, py::arg("name"), "tum1, tum2 or tum3; None for others.");
  py::enum_<ImuSampleStatus>(module, "ImuSampleStatus")
      .value("ADDED", ImuSampleStatus::kAdded)
      .value("REORDERED", ImuSampleStatus::kReordered)
      .value("DUPLICATE", ImuSampleStatus::kDuplicate)
      .value("TOO_OLD", ImuSampleStatus::kTooOld)
      .value("NOT_FINITE", ImuSampleStatus::kNotFinite)
      .value("IMPOSSIBLE", ImuSampleStatus::kImpossible)
      .value("JUMPED", ImuSampleStatus::kJumped)
      .def_property_readonly(
          "advice", [](ImuSampleStatus status) { return Advice(status); },
          "What is wrong with a reading that was dropped, and what to do; empty if it was not.");
  py::class_<ImuCalibration> imu(module, "ImuCalibration", "An IMU that is fixed to a camera.");
  KeywordConstructor<ImuCalibration>(imu);
  imu.def_readwrite("T_BC", &ImuCalibration::T_BC, "The camera in the frame of the IMU.")
      .def_readwrite("noise", &ImuCalibration::noise)
      .def_readwrite("rate", &ImuCalibration::rate, "[Hz]")
      .def_readwrite("time_offset", &ImuCalibration::time_offset, "[s] t_imu - t_cam, a guess.")
      .def_readwrite("gyroscope_range", &ImuCalibration::gyroscope_range,
                     "[rad/s] where readings of an axis end.")
      .def_readwrite("accelerometer_range", &ImuCalibration::accelerometer_range,
                     "[m/s^2] where readings of an axis end.");
  py::class_<SensorCalibration>(module, "SensorCalibration", "The sensors of a recording.")
      .def_readwrite("sensor", &SensorCalibration::sensor)
      .def_readwrite("imu", &SensorCalibration::imu, "None where it is unknown.")
      .def_readwrite("antenna_B", &SensorCalibration::antenna_B,
                     "[m] The antenna of a GPS in the frame of the IMU, or of the camera.")
      .def_readonly("format", &SensorCalibration::format,
                    "What a file of another system is; empty for calibration.yaml.")
      .def_readonly("defaults", &SensorCalibration::defaults,
                    "The keys of calibration.yaml that such a file does not state.");
}

void BindDataset(py::module_& module) {
  py::class_<RgbdImage>(module, "RgbdImage", "A colour and a depth image of one stamp.")
      .def_readonly("stamp", &RgbdImage::stamp, "[ns]")
      .def_property_readonly("bgr", [](const RgbdImage& image) { return ImageArray(image.bgr); })
      .def_property_readonly(
          "depth", [](const RgbdImage& image) { return ImageArray(image.depth); }, "[m]");
  py::class_<Dataset>(module, "Dataset", "A recording of colour and depth images.")
      .def("__len__", &Dataset::size)
      .def("load", &Dataset::Load, py::arg("index"), py::call_guard<py::gil_scoped_release>(),
           "The images of a frame; None where they cannot be used.")
      .def_property_readonly("groundtruth",
                             [](const Dataset& dataset) -> std::optional<PythonTrajectory> {
                               if (dataset.groundtruth() == nullptr) return std::nullopt;
                               return PythonTrajectory{*dataset.groundtruth()};
                             })
      .def_property_readonly(
          "calibration",
          [](const Dataset& dataset) -> std::optional<SensorCalibration> {
            if (dataset.calibration() == nullptr) return std::nullopt;
            return *dataset.calibration();
          },
          "What the recording itself states of its sensors; None where it states nothing.")
      .def(
          "imu",
          [](const Dataset& dataset) {
            if (!dataset.imu_file() || dataset.size() == 0) return std::vector<ImuSample>();
            return dataset.ReadImu({dataset.stamp(0), dataset.stamp(dataset.size() - 1)}).samples;
          },
          "The readings of its IMU, in the order of the file; empty where it has none.");
  py::class_<TumDataset, Dataset>(module, "TumDataset", "A recording in the layout of TUM RGB-D.")
      .def(
          py::init([](const py::object& directory, const std::optional<RgbdSensor>& sensor,
                      std::optional<double> depth_factor,
                      std::optional<double> inverse_depth_offset,
                      const std::optional<DepthPattern::Vector>& depth_pattern,
                      double max_stamp_difference) {
            RgbdSensor depth = sensor.value_or(RgbdSensor());
            if (depth_factor) depth.depth_factor = *depth_factor;
            if (inverse_depth_offset) depth.inverse_depth_offset = *inverse_depth_offset;
            if (depth_pattern) depth.depth_pattern.nodes = *depth_pattern;
            return std::make_unique<TumDataset>(
                Path(directory), depth,
                DatasetOptions{.max_stamp_difference = max_stamp_difference,
                               .any_size = !sensor.has_value()});
          }),
          py::arg("directory"), py::arg("sensor") = py::none(), py::kw_only(),
          py::arg("depth_factor") = py::none(), py::arg("inverse_depth_offset") = py::none(),
          py::arg("depth_pattern") = py::none(),
          py::arg("max_stamp_difference") = DatasetOptions().max_stamp_difference,
          "sensor: converts the stored depth to metres, and its camera has the size of the images; "
          "the keywords are in the place of its fields.");
  module.def(
      "read_sensor", [](const py::object& path) { return ReadSensor(Path(path)); }, py::arg("path"),
      "Reads a calibration.yaml, which highwall calibrate writes, or a calibration of ORB-SLAM, "
      "OpenCV, ROS, Kalibr, EuRoC or Open3D.");
  module.def(
      "open_dataset",
      [](const py::object& folder, const std::optional<RgbdSensor>& sensor,
         double max_stamp_difference, double frame_rate, const std::string& topics) {
        return OpenDataset(Path(folder), sensor,
                           DatasetOptions{.max_stamp_difference = max_stamp_difference,
                                          .frame_rate = frame_rate,
                                          .topics = ReadBagTopics(topics)});
      },
      py::arg("folder"), py::arg("sensor") = py::none(),
      py::arg("max_stamp_difference") = DatasetOptions().max_stamp_difference,
      py::arg("frame_rate") = DatasetOptions().frame_rate, py::arg("topics") = "",
      "Opens a recording in any format that highwall slam reads. sensor: where the recording does "
      "not state its calibration. frame_rate: where its frames have no stamps. topics: of a bag of "
      "ROS, as "
      "highwall slam --topics takes them; those that are left out are guessed.");
}

void BindSlamOptions(py::module_& module) {
  py::class_<SlamOptions> options(module, "SlamOptions", "Options of a SlamSystem.");
  options.def(
      py::init([](bool points, bool lines, bool loops, bool submaps, bool moving_objects, bool wait,
                  bool deterministic) {
        SlamOptions result;
        result.frame.use_points = points;
        result.frame.use_lines = lines;
        result.loops.enabled = loops;
        result.submaps.enabled = submaps;
        result.tracker.moving.enabled = moving_objects;
        result.mapper.wait = wait;
        return deterministic ? Deterministic(result) : result;
      }),
      py::kw_only(), py::arg("points") = true, py::arg("lines") = true, py::arg("loops") = true,
      py::arg("submaps") = true, py::arg("moving_objects") = true, py::arg("wait") = true,
      py::arg("deterministic") = false,
      "wait: a keyframe waits for the adjustment of the one before; a live camera does not. "
      "deterministic: the same input gives the same output, bit for bit.");
}

// Returns a getter of one of the covariances of a frame.
auto Covariance(Eigen::Matrix<double, 6, 6> PoseUncertainty::*which) {
  return [which](const FrameResult& frame) -> std::optional<Eigen::Matrix<double, 6, 6>> {
    if (!frame.uncertainty) return std::nullopt;
    return *frame.uncertainty.*which;
  };
}

void BindResults(py::module_& module) {
  py::enum_<TrackingState>(module, "TrackingState")
      .value("INITIALIZING", TrackingState::kInitializing)
      .value("TRACKING", TrackingState::kTracking)
      .value("INERTIAL", TrackingState::kInertial)
      .value("LOST", TrackingState::kLost);
  py::class_<FrameResult>(module, "FrameResult", "What became of a frame.")
      .def_readonly("stamp", &FrameResult::stamp, "[ns]")
      .def_readonly("state", &FrameResult::state)
      .def_property_readonly(
          "reason",
          [](const FrameResult& frame) -> std::optional<std::string> {
            if (!frame.reason) return std::nullopt;
            return ToString(*frame.reason);
          },
          "The reason if there is no pose.")
      .def_property_readonly(
          "T_WC",
          [](const FrameResult& frame) -> std::optional<Pose> {
            if (!HasPose(frame.state)) return std::nullopt;
            return frame.T_WC;
          },
          "Causal estimate; None without a pose.")
      .def_property_readonly(
          "covariance", Covariance(&PoseUncertainty::in_map),
          "Of T_WC, 6 x 6: translation [m], then rotation [rad], both along the axes of C; None "
          "without a pose.")
      .def_property_readonly(
          "covariance_in_keyframe", Covariance(&PoseUncertainty::in_keyframe),
          "The same of the pose relative to the keyframe that shares most landmarks with it.")
      .def_readonly("relocalized", &FrameResult::relocalized)
      .def_property_readonly("is_keyframe",
                             [](const FrameResult& frame) { return frame.mapping.has_value(); })
      .def_readonly("points", &FrameResult::points, "Extracted.")
      .def_readonly("lines", &FrameResult::lines, "Extracted.")
      .def_readonly("matched_points", &FrameResult::matched_points)
      .def_readonly("matched_lines", &FrameResult::matched_lines);
  py::class_<FrameVelocity>(module, "FrameVelocity", "The velocity of a frame by all images.")
      .def_readonly("stamp", &FrameVelocity::stamp, "[ns]")
      .def_readonly("v_WC", &FrameVelocity::v_WC, "[m/s] of the camera, in W")
      .def_readonly("omega_C", &FrameVelocity::omega_C, "[rad/s] along the axes of C")
      .def_readonly("covariance", &FrameVelocity::covariance, "6 x 6, of v_WC, then omega_C");
}

template <std::size_t kSize>
Eigen::VectorXd ArrayOf(const std::array<double, kSize>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), kSize);
}

void BindEstimates(py::module_& module) {
  py::class_<FrameTimingEstimate>(module, "FrameTimingEstimate",
                                  "A FrameTiming that was estimated online.")
      .def_readonly("value", &FrameTimingEstimate::value)
      .def_readonly("sigma", &FrameTimingEstimate::sigma, "Standard deviations.");
  py::class_<NoiseEstimate>(module, "NoiseEstimate",
                            "Standard deviations of each kind of measurement, as multiples of the "
                            "prior noise models (docs/noise.md).")
      .def_property_readonly(
          "point_px", [](const NoiseEstimate& noise) { return ArrayOf(noise.point_px); },
          "Of points, across the image, by octave: 16, of which an extractor may have fewer.")
      .def_property_readonly(
          "low_contrast_px",
          [](const NoiseEstimate& noise) { return ArrayOf(noise.low_contrast_px); },
          "Of points of low contrast (PointExtractor), likewise.")
      .def_property_readonly(
          "refined_px", [](const NoiseEstimate& noise) { return ArrayOf(noise.refined_px); },
          "Of those that keyframes have refined, likewise.")
      .def_property_readonly(
          "point_depth", [](const NoiseEstimate& noise) { return ArrayOf(noise.point_depth); },
          "Of their depth: to 1 m, 2 m, 4 m, beyond.")
      .def_property_readonly(
          "edge_depth", [](const NoiseEstimate& noise) { return ArrayOf(noise.edge_depth); },
          "The same where readings about the point differ.")
      .def_property_readonly(
          "line_px", [](const NoiseEstimate& noise) { return ArrayOf(noise.line_px); },
          "Of segments, across them, by length: to 1/16, 1/8, 1/4 of the image's width, beyond.")
      .def_property_readonly(
          "line_depth", [](const NoiseEstimate& noise) { return ArrayOf(noise.line_depth); },
          "Of their depth, as point_depth.");
  py::class_<SensorEstimate>(module, "SensorEstimate", "The current online estimate of the sensor.")
      .def_readonly("timing", &SensorEstimate::timing, "When the rows of images are taken.")
      .def_property_readonly(
          "depth_pattern", [](const SensorEstimate& self) { return self.depth_pattern.nodes; },
          "[1/m] The correction to add to RgbdSensor.depth_pattern.")
      .def_readonly("noise", &SensorEstimate::noise, "Noise of the observations.");
}

void BindVerdict(py::module_& module) {
  py::class_<SensorFinding>(module, "SensorFinding",
                            "One contradiction between the configuration and what is measured.")
      .def_property_readonly(
          "fault", [](const SensorFinding& self) { return ToString(self.fault); },
          "Its kind, such as \"imu mount\".")
      .def_property_readonly(
          "trust", [](const SensorFinding& self) { return ToString(self.trust); },
          "What it leaves of the results: \"doubtful\" or \"not to be trusted\".")
      .def_readonly("text", &SensorFinding::text, "What is wrong, and by how much.")
      .def_readonly("remedy", &SensorFinding::remedy, "What to do about it.")
      .def("__repr__", [](const SensorFinding& self) { return Line(self); });
  py::class_<SensorVerdict>(module, "SensorVerdict", "All that was found in a recording.")
      .def_property_readonly(
          "trust", [](const SensorVerdict& self) { return ToString(self.trust()); },
          "\"consistent\", \"doubtful\" or \"not to be trusted\".")
      .def_readonly("findings", &SensorVerdict::findings)
      .def("__repr__", &SensorVerdict::Summary);
}

using Rows3 = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Rows6 = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>;

Rows3 MapPoints(const SlamSystem& slam) {
  const std::vector<PointId> ids = slam.map().ids<MapPoint>();
  Rows3 rows(static_cast<Eigen::Index>(ids.size()), 3);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    rows.row(static_cast<Eigen::Index>(i)) = slam.map().Find(ids[i])->p_W;
  }
  return rows;
}

Rows6 MapLines(const SlamSystem& slam) {
  const std::vector<LineId> ids = slam.map().ids<MapLine>();
  Rows6 rows(static_cast<Eigen::Index>(ids.size()), 6);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const Segment3& segment = slam.map().Find(ids[i])->segment_W;
    rows.row(static_cast<Eigen::Index>(i)) << segment.p().transpose(), segment.q().transpose();
  }
  return rows;
}

}  // namespace

void BindSlam(py::module_& module) {
  BindSensor(module);
  BindDataset(module);
  BindSlamOptions(module);
  BindResults(module);
  BindEstimates(module);
  BindVerdict(module);
  py::class_<Slam, std::unique_ptr<Slam, UnlockedDelete>>(
      module, "SlamSystem", "RGB-D(-inertial) SLAM: images and readings in, poses and a map out.",
      Collected<Slam>())
      .def(py::init([](const RgbdSensor& sensor, const SlamOptions& options,
                       const std::optional<ImuCalibration>& imu, const py::object& points) {
             return std::unique_ptr<Slam, UnlockedDelete>(
                 new Slam("SlamSystem", [&](const std::shared_ptr<CallGate>& gate) {
                   return PythonSlam(sensor, options, imu, SharePoints(points, gate));
                 }));
           }),
           py::arg("sensor"), py::arg("options") = SlamOptions{}, py::arg("imu") = std::nullopt,
           py::arg("points") = py::none(), "points: a PointExtractor of your own.")
      .def(
          "set_callbacks",
          [](Slam& self, const OptionalFunction& on_keyframe, const OptionalFunction& on_loop,
             const OptionalFunction& on_map, const OptionalFunction& on_finding,
             const OptionalFunction& on_frame) {
            SlamCallbacks callbacks =
                MakeCallbacks(*self.gate(), on_keyframe, on_loop, on_map, on_finding, on_frame);
            self.Call([&](PythonSlam& slam) { slam.Listen(std::move(callbacks)); });
          },
          py::kw_only(), py::arg("on_keyframe") = py::none(), py::arg("on_loop") = py::none(),
          py::arg("on_map") = py::none(), py::arg("on_finding") = py::none(),
          py::arg("on_frame") = py::none(),
          "on_keyframe(id, T_WC, stamp, bgr, depth), on_loop(match, keyframe, accepted, message), "
          "on_map({id: T_WC}), on_finding(SensorFinding), on_frame(FrameResult): called by track() "
          "and finish(). What one raises reaches the caller. They must not call the system in "
          "turn: a RuntimeError.")
      .def("add_imu", Exclusively<PythonSlam>(&SlamSystem::AddImu), py::arg("sample"),
           "All readings until some 50 ms after an image must be passed before that image.")
      .def(
          "add_reference_frame",
          [](Slam& self, bool upright) {
            return self.Call([upright](SlamSystem& slam) {
              return slam.AddReferenceFrame({.upright = upright}).value();
            });
          },
          py::arg("upright") = true,
          "A frame F that factors of your own are measured in: its number. upright: its z axis "
          "points up.")
      .def("add_factor", &AddFactor, py::arg("stamps"), py::arg("factor"),
           py::arg("frame") = std::nullopt, py::arg("loss") = std::nullopt, py::arg("source") = "",
           "A user factor: a factor on the poses T_WB at the stamps [ns], then, where "
           "there is a frame, of T_FW. source: name of the sensor, to count by. An exception that "
           "a factor written in Python raises "
           "later goes to sys.unraisablehook.")
      .def(
          "T_FW",
          [](Slam& self, int frame) {
            return self.Call(
                [frame](const SlamSystem& slam) { return slam.T_FW(ReferenceFrameId(frame)); });
          },
          py::arg("frame"), "Where F lies; None as long as that is not known.")
      .def_property_readonly("factor_counts", Exclusively<PythonSlam>(&SlamSystem::factor_counts))
      .def_property_readonly("factor_counts_by_source",
                             Exclusively<PythonSlam>(&SlamSystem::factor_counts_by_source),
                             "The same for each source named in add_factor().")
      .def(
          "track",
          [](Slam& self, Stamp stamp, const py::object& bgr, const py::object& depth) {
            const RgbdImage image = MakeImage(stamp, bgr, depth);
            return self.Call([&](PythonSlam& slam) { return slam.TrackImage(image); });
          },
          py::arg("stamp"), py::arg("bgr"), py::arg("depth"),
          "bgr: height x width x 3, uint8, as cv2.imread reads it. depth: height x width, metres, "
          "0 where nothing was measured. Stamps [ns] ascend.")
      .def(
          "set_backlog",
          [](Slam& self, std::size_t images) {
            self.Call([images](SlamSystem& slam) { slam.SetBacklog(images); });
          },
          py::arg("images"),
          "Before track(), for a camera that does not wait: the number of images that wait. While "
          "there are any, keyframes, loops and refinement wait.")
      .def(
          "postponed",
          [](Slam& self) {
            const PostponedWork postponed =
                self.Call([](const SlamSystem& slam) { return slam.postponed(); });
            return py::dict(py::arg("keyframes") = postponed.keyframes,
                            py::arg("loop_searches") = postponed.loop_searches);
          },
          "How often a keyframe or the search for a loop was postponed.")
      .def(
          "finish", [](Slam& self) { self.Call([](SlamSystem& slam) { slam.Finish(); }); },
          "Ends the run: waits for adjustments and loops, and applies them, and a loop of the last "
          "keyframes.")
      .def(
          "trajectory",
          [](Slam& self) {
            return PythonTrajectory{
                self.Call([](const SlamSystem& slam) { return slam.trajectory(); })};
          },
          "T_WC of every tracked frame after all adjustments so far.")
      .def("keyframe_trajectory",
           [](Slam& self) {
             return PythonTrajectory{
                 self.Call([](const SlamSystem& slam) { return slam.keyframe_trajectory(); })};
           })
      .def("velocities", Exclusively<PythonSlam>(&SlamSystem::velocities),
           "After finish(): the velocities of the frames of trajectory() that have one.")
      .def("sensor", Exclusively<PythonSlam>(&SlamSystem::sensor),
           "Online estimate of the sensor, as it is now.")
      .def("verdict", Exclusively<PythonSlam>(&SlamSystem::verdict),
           "What contradicts the configuration of the sensors; complete after finish().")
      .def("refined_frames", Exclusively<PythonSlam>(&SlamSystem::refined_frames),
           "Number of frames whose pose was refined afterwards.")
      .def(
          "map_points", [](Slam& self) { return self.Call(&MapPoints); }, "[m] n x 3 in W.")
      .def(
          "map_lines", [](Slam& self) { return self.Call(&MapLines); },
          "[m] n x 6 in W: both ends.")
      .def(
          "save_map",
          [](Slam& self, const py::object& object, const PinholeCamera& camera) {
            const std::filesystem::path path = Path(object);
            return self.Call([&](const SlamSystem& slam) {
              return SaveMap(path, camera.WithoutDistortion(), slam.map());
            });
          },
          py::arg("path"), py::arg("camera"),
          "Returns how many factors of your own the file does not keep: all but those of a "
          "PositionFactor or a RelativePose with no loss or Huber's.");
}

}  // namespace highwall::python
