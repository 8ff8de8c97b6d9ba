#include "simulate/imu_files.h"

#include <iomanip>
#include <limits>
#include <sstream>

namespace highwall::simulate {
namespace {

constexpr int kDecimals = 9;

void Append(const Eigen::Vector3d& v, std::ostream& out) {
  out << ',' << v.x() << ',' << v.y() << ',' << v.z();
}

}  // namespace

std::string ImuCsv(std::span<const ImuSample> samples) {
  std::ostringstream out;
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
  std::ostringstream out;
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
  std::ostringstream out;
  out << std::setprecision(std::numeric_limits<double>::max_digits10) << "imu:\n  T_BC: [";
  const Eigen::Matrix4d T_BC = options.T_BC.Matrix();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      if (row + column > 0) out << (column == 0 ? ",\n         " : ", ");
      out << T_BC(row, column);
    }
  }
  out << "]\n  gyroscope_noise: " << options.noise.gyroscope
      << "\n  accelerometer_noise: " << options.noise.accelerometer
      << "\n  gyroscope_walk: " << options.noise.gyroscope_walk
      << "\n  accelerometer_walk: " << options.noise.accelerometer_walk
      << "\n  rate: " << options.rate << "\n  time_offset: 0\n";
  return out.str();
}

}  // namespace highwall::simulate
