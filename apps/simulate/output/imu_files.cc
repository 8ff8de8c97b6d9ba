#include "simulate/output/imu_files.h"

#include <cmath>
#include <iomanip>
#include <utility>

#include <highwall/internal/number_text.h>

namespace highwall::simulate {
namespace {

constexpr int kDecimals = 9;

void Append(const Eigen::Vector3d& v, std::ostream& out) {
  out << ',' << v.x() << ',' << v.y() << ',' << v.z();
}

}  // namespace

std::string ImuCsv(std::span<const ImuSample> samples) {
  TextWriter out;
  out << "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
         "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n"
      << std::fixed << std::setprecision(kDecimals);
  for (const ImuSample& sample : samples) {
    out << sample.stamp;
    Append(sample.gyroscope, out);
    Append(sample.accelerometer, out);
    out << '\n';
  }
  return out.str();
}

std::string StateCsv(const Simulation& simulation, const std::vector<Stamp>& stamps) {
  TextWriter out;
  out << "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],"
         "q_RS_z [],v_RS_R_x [m s^-1],v_RS_R_y [m s^-1],v_RS_R_z [m s^-1],b_w_RS_S_x [rad s^-1],"
         "b_w_RS_S_y [rad s^-1],b_w_RS_S_z [rad s^-1],b_a_RS_S_x [m s^-2],b_a_RS_S_y [m s^-2],"
         "b_a_RS_S_z [m s^-2]\n"
      << std::fixed << std::setprecision(kDecimals);
  const Stamp offset = FromSeconds(simulation.options().imu.time_offset);
  for (const Stamp stamp : stamps) {
    const TrueState truth = simulation.StateAt(stamp);
    const Eigen::Quaterniond q = truth.state.T_WB.q();
    out << stamp + offset;
    Append(truth.state.T_WB.p(), out);
    out << ',' << q.w();
    Append(q.vec(), out);
    Append(truth.state.v_WB, out);
    Append(truth.bias.head<3>(), out);
    Append(truth.bias.tail<3>(), out);
    out << '\n';
  }
  return out.str();
}

std::string ImuCalibrationYaml(const ImuSimulationOptions& options) {
  std::string yaml = "imu:\n  T_BC: [";
  const Eigen::Matrix4d T_BC = options.T_BC.Matrix();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      if (row + column > 0) yaml += column == 0 ? ",\n         " : ", ";
      yaml += NumberText(T_BC(row, column));
    }
  }
  yaml += "]\n";
  const ImuNoise& noise = options.noise;
  for (const auto& [key, value] : {std::pair("gyroscope_noise", noise.gyroscope),
                                   {"accelerometer_noise", noise.accelerometer},
                                   {"gyroscope_walk", noise.gyroscope_walk},
                                   {"accelerometer_walk", noise.accelerometer_walk},
                                   {"rate", options.rate},
                                   {"time_offset", 0.0}}) {
    yaml += std::string("  ") + key + ": " + NumberText(value) + "\n";
  }
  const ImuFaults& faults = options.faults;
  for (const auto& [key, range] : {std::pair("gyroscope_range", faults.gyroscope_range),
                                   {"accelerometer_range", faults.accelerometer_range}}) {
    if (std::isfinite(range)) yaml += std::string("  ") + key + ": " + NumberText(range) + "\n";
  }
  return yaml;
}

}  // namespace highwall::simulate
