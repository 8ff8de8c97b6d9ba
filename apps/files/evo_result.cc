#include "files/evo_result.h"

#include <cstdint>
#include <cstring>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <highwall/core/stamp.h>

#include "files/json_text.h"
#include "files/zip_file.h"

namespace highwall::apps {
namespace {

// Encodes an array of doubles in NumPy's format, version 1.0 (NEP 1): magic, header length, header,
// values. The values begin at a multiple of 64 bytes.
std::string Npy(const std::vector<double>& values) {
  std::string header =
      fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}", values.size());
  constexpr std::size_t kBefore = 10;
  header.append((64 - (kBefore + header.size() + 1) % 64) % 64, ' ');
  header += '\n';
  std::string bytes("\x93NUMPY\x01\x00", 8);
  bytes += static_cast<char>(header.size() & 0xFFU);
  bytes += static_cast<char>(header.size() >> 8);
  bytes += header;
  const std::size_t at = bytes.size();
  bytes.resize(at + 8 * values.size());
  std::memcpy(bytes.data() + at, values.data(), 8 * values.size());
  return bytes;
}

std::string Tum(const Trajectory& trajectory) {
  std::string text;
  for (const StampedPose& stamped : trajectory) {
    const double* d = stamped.pose.data();
    text += fmt::format("{} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n",
                        FormatStamp(stamped.stamp), d[0], d[1], d[2], d[3], d[4], d[5], d[6]);
  }
  return text;
}

}  // namespace

void WriteEvoResult(const std::filesystem::path& path, const EvoResultInfo& info,
                    const TrajectoryError& result) {
  const ErrorStatistics& s = result.statistics;
  const nlohmann::json stats = {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median},
                                {"std", s.std},   {"min", s.min},   {"max", s.max},
                                {"sse", s.sse}};
  const nlohmann::json description = {{"title", info.title},
                                      {"label", info.label},
                                      {"ref_name", info.reference},
                                      {"est_name", info.estimate}};
  std::vector<double> stamps, seconds;
  for (const std::size_t index : result.indices) {
    const Stamp stamp = result.estimate[index].stamp;
    stamps.push_back(ToSeconds(stamp));
    seconds.push_back(ToSeconds(stamp - result.estimate.front().stamp));
  }
  ZipFile zip;
  zip.Add("info.json", JsonText(description));
  zip.Add("stats.json", JsonText(stats));
  zip.Add("error_array.npy", Npy(result.errors));
  zip.Add("timestamps.npy", Npy(stamps));
  zip.Add("seconds_from_start.npy", Npy(seconds));
  zip.Add("reference.tum", Tum(result.reference));
  zip.Add("estimate.tum", Tum(result.estimate));
  zip.Write(path);
}

}  // namespace highwall::apps
