#include <highwall/frontend/input/gps.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>

namespace highwall {
namespace {

constexpr const char* kForm =
    "a fix is a stamp [s], three coordinates and, or not, their three sigmas [m]";

// Local frame of metres east, north and up at a position on WGS 84.
class LocalFrame {
 public:
  // lla: latitude, longitude [deg], altitude [m].
  explicit LocalFrame(const Eigen::Vector3d& lla) : origin_(ToEarth(lla)) {
    const double lat = Radians(lla.x()), lon = Radians(lla.y());
    R_GE_ << -std::sin(lon), std::cos(lon), 0.0,                                        //
        -std::sin(lat) * std::cos(lon), -std::sin(lat) * std::sin(lon), std::cos(lat),  //
        std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat);
  }
  Eigen::Vector3d ToLocal(const Eigen::Vector3d& lla) const {
    return R_GE_ * (ToEarth(lla) - origin_);
  }

 private:
  static double Radians(double degrees) { return degrees * M_PI / 180.0; }
  // Earth-centred coordinates. (NIMA TR8350.2, 2000: the ellipsoid's two numbers.)
  static Eigen::Vector3d ToEarth(const Eigen::Vector3d& lla) {
    constexpr double kEquator = 6378137.0, kFlattening = 1.0 / 298.257223563;
    constexpr double kE2 = kFlattening * (2.0 - kFlattening);
    const double lat = Radians(lla.x()), lon = Radians(lla.y());
    const double n = kEquator / std::sqrt(1.0 - kE2 * std::sin(lat) * std::sin(lat));
    return {(n + lla.z()) * std::cos(lat) * std::cos(lon),
            (n + lla.z()) * std::cos(lat) * std::sin(lon),
            (n * (1.0 - kE2) + lla.z()) * std::sin(lat)};
  }

  Eigen::Vector3d origin_;
  Eigen::Matrix3d R_GE_;
};

constexpr std::string_view kBetweenGpsFields = ", \t\r";

bool IsHeading(std::string_view line) {
  return std::isalpha(static_cast<unsigned char>(line.front())) != 0 && !line.starts_with("nan");
}

// Returns whether a column of this heading is a latitude, however its unit is written.
bool NamesLatitude(std::string_view heading) {
  for (const std::string_view field : SplitWords(heading, kBetweenGpsFields)) {
    std::string word;
    for (const char c : field) {
      if (c == '#' && word.empty()) continue;
      if (std::isalpha(static_cast<unsigned char>(c)) == 0) break;
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    if (word == "lat" || word == "latitude") return true;
  }
  return false;
}

GpsFix ParseFix(const std::filesystem::path& path, std::int64_t number, std::string_view line) {
  const std::vector<std::string_view> fields = SplitWords(line, kBetweenGpsFields);
  if (fields.size() != 4 && fields.size() != 7) {
    throw IoError(path, number, "has " + std::to_string(fields.size()) + " fields; " + kForm);
  }
  const std::optional<Stamp> stamp = ParseStamp(fields[0]);
  if (!stamp) {
    throw IoError(path, number,
                  "'" + std::string(fields[0]) + "' is not a time stamp; write seconds");
  }
  std::vector<double> values;
  for (const std::string_view field : std::span(fields).subspan(1)) {
    if (!ParseNumber(field, &values.emplace_back())) {
      throw IoError(path, number,
                    "'" + std::string(field) + "' is not a number; correct the line or remove it");
    }
  }
  GpsFix fix{*stamp, {values[0], values[1], values[2]}, {2.5, 2.5, 5.0}};
  if (values.size() == 6) fix.sigma = {values[3], values[4], values[5]};
  if (!fix.p_G.allFinite()) return fix;
  // Within these bounds squares, and the quotients by squared sigmas, remain finite.
  constexpr double kLargest = 1e9, kSmallest = 1e-9;  // [m]
  if (fix.p_G.cwiseAbs().maxCoeff() > kLargest) {
    throw IoError(path, number, "is farther away than any place on Earth; " + std::string(kForm));
  }
  const auto sigma = fix.sigma.array();
  if (!(sigma >= kSmallest && sigma <= kLargest).all()) {
    throw IoError(path, number, "has a sigma that is not positive; " + std::string(kForm));
  }
  return fix;
}

}  // namespace

std::vector<GpsFix> ReadGps(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file || std::filesystem::is_directory(path)) {
    throw IoError(path, "is missing or cannot be read");
  }
  std::vector<GpsFix> fixes;
  bool geodetic = false;
  std::string line;
  for (std::int64_t number = 1; std::getline(file, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    if (line.front() == '#' || IsHeading(line)) {
      geodetic = geodetic || NamesLatitude(line);
      continue;
    }
    const GpsFix fix = ParseFix(path, number, line);
    if (fix.p_G.allFinite()) fixes.push_back(fix);
  }
  if (fixes.empty()) throw IoError(path, "holds no fix: " + std::string(kForm));
  std::ranges::stable_sort(fixes, {}, &GpsFix::stamp);
  if (!geodetic) return fixes;
  const LocalFrame frame(fixes.front().p_G);
  for (GpsFix& fix : fixes) {
    if (std::abs(fix.p_G.x()) > 90.0 || std::abs(fix.p_G.y()) > 360.0) {
      throw IoError(path, "the heading names lat, but " + FixedText(fix.p_G.x()) + " " +
                              FixedText(fix.p_G.y()) +
                              " is no latitude and longitude [deg]: name the columns x y z");
    }
    fix.p_G = frame.ToLocal(fix.p_G);
  }
  return fixes;
}

}  // namespace highwall
