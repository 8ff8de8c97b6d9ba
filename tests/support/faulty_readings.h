#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <highwall/core/stamp.h>
#include <highwall/factors/imu_buffer.h>

// Seeded faults in the readings of an IMU.
namespace highwall::testing {

enum class Fault {
  kNotFinite,   // NaN or infinite values
  kImpossible,  // spikes beyond the range of any sensor
  kSpike,       // spikes within the range of some sensors
  kFrozen,      // one reading repeated
  kSwapped,     // neighbours in the wrong order
  kMissing,     // a gap
  kTwice,       // a duplicate stamp
};
inline constexpr int kFaults = 7;

inline int Uniform(std::mt19937& rng, int low, int high) {
  return std::uniform_int_distribution<int>(low, high)(rng);
}

// Returns a value between both, uniform in its logarithm, of either sign.
inline double Magnitude(std::mt19937& rng, double low, double high) {
  const double value =
      std::exp(std::uniform_real_distribution<double>(std::log(low), std::log(high))(rng));
  return Uniform(rng, 0, 1) == 0 ? value : -value;
}

inline double& AnyValue(std::mt19937& rng, ImuSample& reading) {
  const int axis = Uniform(rng, 0, 5);
  return axis < 3 ? reading.gyroscope(axis) : reading.accelerometer(axis - 3);
}

// Applies one fault in the second half of `readings`, which keep at least two thirds of their
// number.
inline void Inject(Fault fault, std::mt19937& rng, std::vector<ImuSample>& readings) {
  const int size = static_cast<int>(readings.size());
  const int begin = Uniform(rng, size / 2, size - 90);
  const auto at = [&](int i) -> ImuSample& { return readings[static_cast<std::size_t>(i)]; };
  const auto first = readings.begin() + begin;
  switch (fault) {
    case Fault::kNotFinite:
      for (int i = 0, end = Uniform(rng, 1, 12); i < end; ++i) {
        const double inf = std::numeric_limits<double>::infinity();
        AnyValue(rng, at(begin + 2 * i)) = Uniform(rng, 0, 1) == 0 ? std::nan("") : inf;
      }
      return;
    case Fault::kImpossible:
      for (int i = 0, end = Uniform(rng, 1, 12); i < end; ++i) {
        AnyValue(rng, at(begin + 2 * i)) = Magnitude(rng, 1.001 * kMaxSpecificForce, 1e300);
      }
      return;
    case Fault::kSpike:
      for (int i = 0, end = Uniform(rng, 1, 3); i < end; ++i) {
        const int axis = Uniform(rng, 0, 2);
        ImuSample& reading = at(begin + Uniform(rng, 0, 80));
        if (Uniform(rng, 0, 1) == 0) {
          reading.gyroscope(axis) = Magnitude(rng, 1.0, kMaxAngularRate);
        } else {
          reading.accelerometer(axis) = Magnitude(rng, 20.0, kMaxSpecificForce);
        }
      }
      return;
    case Fault::kFrozen:
      for (int i = 1, end = Uniform(rng, 5, 80); i < end; ++i) {
        at(begin + i).gyroscope = first->gyroscope;
        at(begin + i).accelerometer = first->accelerometer;
      }
      return;
    case Fault::kSwapped:
      for (int i = 0, end = Uniform(rng, 1, 10); i < end; ++i)
        std::swap(at(begin + 2 * i), at(begin + 2 * i + 1));
      return;
    case Fault::kMissing:
      readings.erase(first, first + Uniform(rng, 1, 80));
      return;
    case Fault::kTwice:
      at(begin + 1).stamp = first->stamp;
      return;
  }
}

// Applies one to three kinds of faults, each once.
inline std::set<Fault> InjectSome(std::mt19937& rng, std::vector<ImuSample>& readings) {
  std::set<Fault> faults;
  const int wanted = Uniform(rng, 1, 3);
  while (static_cast<int>(faults.size()) < wanted) {
    faults.insert(static_cast<Fault>(Uniform(rng, 0, kFaults - 1)));
  }
  for (const Fault fault : faults) Inject(fault, rng, readings);
  return faults;
}

// Returns the number of seeds of a fault test: the environment variable HIGHWALL_FAULT_RUNS, or
// `usual`.
inline int FaultRuns(int usual) {
  const char* text = std::getenv("HIGHWALL_FAULT_RUNS");
  return text == nullptr ? usual : std::atoi(text);
}

}  // namespace highwall::testing
