#include <highwall/frontend/input/sensor.h>

#include "fuzz.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "calibration.yaml",
    .seeds =
        [] {
          const std::string camera =
              "camera:\n  width: 640\n  height: 480\n  fx: 525.0\n  fy: 525.0\n  cx: 319.5\n"
              "  cy: 239.5\n  k1: 0.1\ndepth_factor: 5000\n";
          return std::vector<std::string>{
              camera,
              camera +
                  "depth_noise: {offset: 0.001, quadratic: 0.0019, reference: 0.4}\n"
                  "imu:\n  T_BC: [1, 0, 0, 0.1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n"
                  "  gyroscope_noise: 1e-3\n  accelerometer_noise: 1e-2\n  gyroscope_walk: 1e-5\n"
                  "  accelerometer_walk: 1e-4\n  rate: 200\n  time_offset: 0.002\n",
              "a: &x [1, {b: 'c'}]\n? *x\n: !!str |\n  text\n--- # another\n"};
        },
    .file = nullptr,
    .read = [](const std::filesystem::path& path) { ReadSensor(path); },
};

}  // namespace highwall::fuzz
