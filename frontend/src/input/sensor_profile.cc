#include <highwall/frontend/input/sensor_profile.h>

namespace highwall {
namespace {

// Standard deviation of a D400 disparity: 0.032 px at best, 0.08 px as a safe value (A.
// Grunnet-Jepsen of Intel, librealsense issue 3904).
constexpr double kRealSenseSubpixel = 0.08;

// D400: disparities in 1/32 px: the legacy disparity format holds 1000 / z [1/m] for a pair with
// 640 px and 50 mm (librealsense issue 2139). The modes 1280 x 720, 848 x 480, 640 x 480 and 640 x
// 360 scale the full imager, and their focal lengths with it. The pair of a D430 module, in a D435,
// has 640 to 645 px at 1280 columns, 424 to 427 at 848 and 384 at 640 x 480 (librealsense issue
// 11511, realsense-ros issue 2788); its colour camera has 927 and 618. Min-Z is 126 px of disparity
// (librealsense issue 3039) in the smallest mode; beyond 10 m the data sheet (Intel 337029) gives
// only "10 m+".
constexpr StereoPair kD435{.baseline = 0.05, .focals = {424.0, 384.0, 642.0, 321.0}};
// D415: 65 degrees at 2 m where both imagers overlap (data sheet, sections 4.3 and 4.4): 983 px at
// 1280 columns; individual cameras have up to 7 % less. The imager has 1080 rows; 480 rows are a
// scale of 0.44.
constexpr StereoPair kD415{
    .baseline = 0.055, .focals = {950.0, 630.0, 633.0, 475.0}, .focal_tolerance = 0.04};
constexpr StereoPair kD455{.baseline = 0.095, .focals = {424.0, 384.0, 637.0, 318.0}};
// Khoshelham, Elberink, "Accuracy and Resolution of Kinect Depth Data for Indoor Mapping
// Applications", Sensors 2012: 75 mm, 1/8 px. 580 px: the ROS calibration has inverse depth 3.33 -
// 0.0031 x disparity, 2.87e-3 / m per step. Individual cameras scale their depth by up to 4 %.
constexpr StereoPair kKinect{
    .baseline = 0.075, .disparity_step = 1.0 / 8.0, .focals = {580.0}, .focal_tolerance = 0.04};

constexpr std::array<SensorProfile, 10> kProfiles{{
    // Microsoft gives 0.8 to 4 m, 0.4 m in near mode. The drivers return readings up to 10 m; near
    // that limit only readings with errors to the near side remain, with a sigma of 0.14 m (Nguyen,
    // Izadi, Lovell, 3DIMPVT 2012) and a step of 0.23 m at 9 m.
    {.name = "kinect1",
     .title = "Microsoft Kinect (first), ASUS Xtion",
     .principle = DepthPrinciple::kTriangulation,
     .min_depth = 0.4,
     .max_depth = 9.0,
     .pair = kKinect},
    // 0.5 to 4.5 m, returned up to 8 m. Fankhauser et al., "Kinect v2 for mobile robot navigation:
    // evaluation and modeling", ICAR 2015: 1.5 - 0.5 z + 0.3 z^2 [mm], indoors, at normal
    // incidence.
    {.name = "kinect2",
     .title = "Microsoft Kinect v2",
     .principle = DepthPrinciple::kTimeOfFlight,
     .min_depth = 0.5,
     .max_depth = 8.0,
     .noise = {.offset = 0.00129, .quadratic = 0.0003, .reference = 0.833}},
    // Microsoft, "Azure Kinect DK hardware specifications": 0.25 m (WFOV) to 5.46 m (NFOV binned),
    // and readings beyond on reflective surfaces; random error 17 mm at 3.5 m, confirmed by
    // Toelgyessy et al., Sensors 2021, where it is 1 mm at the nearest distance.
    {.name = "azure",
     .title = "Microsoft Azure Kinect",
     .principle = DepthPrinciple::kTimeOfFlight,
     .min_depth = 0.25,
     .max_depth = 5.46,
     .noise = {.offset = 0.001, .quadratic = 0.0013, .reference = 0.0},
     .round_field = true},
    {.name = "d415",
     .title = "Intel RealSense D415",
     .principle = DepthPrinciple::kTriangulation,
     .min_depth = 0.15,
     .max_depth = 20.0,
     .subpixel = kRealSenseSubpixel,
     .focal_ratio = 1.02,
     .pair = kD415},
    {.name = "d435",
     .title = "Intel RealSense D435, D435i",
     .principle = DepthPrinciple::kTriangulation,
     .min_depth = 0.08,
     .max_depth = 20.0,
     .subpixel = kRealSenseSubpixel,
     .focal_ratio = 0.69,
     .pair = kD435},
    {.name = "d455",
     .title = "Intel RealSense D455",
     .principle = DepthPrinciple::kTriangulation,
     .min_depth = 0.15,
     .max_depth = 20.0,
     .subpixel = kRealSenseSubpixel,
     .focal_ratio = 0.99,
     .pair = kD455},
    // Intel, "RealSense LiDAR Camera L515" data sheet: 0.25 to 9 m, standard deviation 2.5 mm at
    // 1 m and 15.5 mm at 9 m; a depth unit is 0.25 mm (librealsense issue 8058).
    {.name = "l515",
     .title = "Intel RealSense L515",
     .principle = DepthPrinciple::kTimeOfFlight,
     .min_depth = 0.25,
     .max_depth = 9.0,
     .depth_factor = 4000.0,
     .noise = {.offset = 0.0023, .quadratic = 0.000163, .reference = 0.0}},
    // Up to 5 m (Apple). Single images lie within 1 mm of a plane at 1 to 1.5 m, maps within 1 cm
    // (Teo, Yang, "Evaluating the accuracy and quality of an iPad Pro's built-in lidar for 3D
    // indoor mapping", Developments in the Built Environment 2023): most of the error is hidden by
    // smoothing. The curve has 1 cm at 2 m.
    {.name = "iphone",
     .title = "LiDAR of an iPhone or iPad Pro",
     .principle = DepthPrinciple::kTimeOfFlight,
     .min_depth = 0.1,
     .max_depth = 5.0,
     .noise = {.offset = 0.002, .quadratic = 0.002, .reference = 0.0},
     .dense = true},
    // Research Mode: 0.2 to 1 m near, up to 4 m far (HoloLensForCV issue 56), up to 7.5 m with the
    // second generation (Ungureanu et al., "HoloLens 2 Research Mode", 2020), whose chip is that of
    // the Azure Kinect; it has no noise curve of its own, so that of the Azure Kinect is used.
    {.name = "hololens",
     .title = "Microsoft HoloLens",
     .principle = DepthPrinciple::kTimeOfFlight,
     .min_depth = 0.2,
     .max_depth = 7.5,
     .noise = {.offset = 0.001, .quadratic = 0.0013, .reference = 0.0},
     .round_field = true},
    {.name = "generic", .title = "any depth camera"},
}};

}  // namespace

DepthNoise SensorProfile::NoiseFor(const PinholeCamera& camera) const {
  if (subpixel == 0.0) return noise;
  return DepthNoise::Stereo(subpixel, focal_ratio * camera.fx, pair->baseline);
}

RgbdSensor SensorProfile::SensorFor(const PinholeCamera& camera) const {
  camera.Validate();
  return {.camera = camera,
          .depth_factor = depth_factor,
          .depth_noise = NoiseFor(camera),
          .min_depth = min_depth,
          .max_depth = max_depth};
}

std::span<const SensorProfile> SensorProfiles() {
  return kProfiles;
}

const SensorProfile* FindSensorProfile(std::string_view name) {
  for (const SensorProfile& profile : kProfiles) {
    if (profile.name == name) return &profile;
  }
  return nullptr;
}

std::string SensorProfileList() {
  std::string list;
  for (const SensorProfile& profile : kProfiles) {
    list += (list.empty() ? "" : ", ") + std::string(profile.name);
  }
  return list;
}

}  // namespace highwall
