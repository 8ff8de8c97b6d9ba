#include "features/segment_depth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include <Eigen/LU>

#include <highwall/core/error.h>

namespace highwall {
namespace {

constexpr int kPositions = 24;  // positions along the segment; four depth pixels at each
constexpr int kPixelsPerSide = 2;
constexpr double kHalfWidth = 2.0;     // [px] distance of the farthest pixels on each side
constexpr double kInlierSigmas = 3.0;  // maximum residual of a measurement that fits the line
constexpr double kMinInliers = 0.6;    // share of the measurements that must fit the line
constexpr int kRansacIterations = 16;  // per side
constexpr std::uint32_t kSeed = 1;     // of the random pairs: equal input gives equal output
constexpr double kMaxRms = 1.5;        // of the inliers' residuals, in sigmas

struct Sample {
  double t;              // along the segment, 0 at s, 1 at e
  double w;              // across it, in steps of kHalfWidth / kPixelsPerSide
  double rho;            // [1/m] inverse depth
  double inverse_sigma;  // [m] of rho
};

constexpr int kMaxPixels = 2 * kPixelsPerSide * kPositions;
// One number of each sample, on the stack, since this runs for every segment of every frame.
using Column = Eigen::Array<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxPixels, 1>;

// Samples by columns, which are added up two numbers at a time.
class Samples {
 public:
  void Add(const Sample& sample) {
    data_.row(size_++) << sample.t, sample.w, sample.rho, sample.inverse_sigma;
  }
  void Add(const Samples& other) {
    data_.middleRows(size_, other.size_) = other.data_.topRows(other.size_);
    size_ += other.size_;
  }
  int size() const { return size_; }
  Sample operator[](int i) const { return {data_(i, 0), data_(i, 1), data_(i, 2), data_(i, 3)}; }
  auto t() const { return data_.col(0).head(size_); }
  auto w() const { return data_.col(1).head(size_); }
  auto rho() const { return data_.col(2).head(size_); }
  auto inverse_sigma() const { return data_.col(3).head(size_); }

 private:
  Eigen::Array<double, kMaxPixels, 4> data_;
  int size_ = 0;
};

// rho(t, w) = a + b t + c w: inverse depth is affine over the image of a plane.
struct InverseDepth {
  double a = 0.0, b = 0.0, c = 0.0;

  // On the segment (w = 0).
  double At(double t) const { return a + b * t; }
  // Residuals in sigmas.
  Column Residuals(const Samples& samples) const {
    return (a + b * samples.t() + c * samples.w() - samples.rho()) * samples.inverse_sigma();
  }
};

// Whether c is fitted. Both sides together determine it separately from a; one side alone would
// have to extrapolate, and the slope over its one or two pixels is below the noise.
enum class Slope { kZero, kFitted };

struct Fit {
  InverseDepth model;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of (a, b)
  double inlier_share = 0.0;
  double rms_sigmas = 0.0;
  double rms = 0.0;  // [m]
};

// Collects the depth pixels on one side (-1 or 1) of the segment.
Samples Collect(const LineSegment& segment, int side, const cv::Mat& depth,
                const RgbdSensor& sensor, const cv::Mat& noise_factor) {
  const PinholeCamera& camera = sensor.camera;
  Samples samples;
  const Eigen::Vector2d s = segment.s.cast<double>(), d = segment.e.cast<double>() - s;
  const Eigen::Vector2d n = Eigen::Vector2d(d.y(), -d.x()).normalized() * side;
  const bool distorted = camera.HasDistortion();
  for (int i = 0; i < kPositions; ++i) {
    const double t = (i + 0.5) / kPositions;
    for (int k = 1; k <= kPixelsPerSide; ++k) {
      Eigen::Vector2d uv = s + t * d + (k * kHalfWidth / kPixelsPerSide) * n;
      if (distorted) {
        const Eigen::Vector2d m =
            camera.Distort({(uv.x() - camera.cx) / camera.fx, (uv.y() - camera.cy) / camera.fy});
        uv = {camera.fx * m.x() + camera.cx, camera.fy * m.y() + camera.cy};
      }
      if (!camera.Contains(uv)) continue;
      const int row = static_cast<int>(uv.y() + 0.5), column = static_cast<int>(uv.x() + 0.5);
      const double z = depth.at<float>(row, column);
      if (!(z >= sensor.min_depth && z <= sensor.max_depth)) continue;  // also NaN
      const double noise = noise_factor.empty() ? 1.0 : noise_factor.at<float>(row, column);
      const double sigma = noise * sensor.depth_noise.Sigma(z);
      samples.Add({t, static_cast<double>(side * k), 1.0 / z, z * z / sigma});
    }
  }
  return samples;
}

// Returns the best model through two samples of one side by the truncated squared residuals (MSAC).
InverseDepth Ransac(const Samples& samples) {
  const double limit = kInlierSigmas * kInlierSigmas;
  InverseDepth best;
  double best_score = std::numeric_limits<double>::infinity();
  std::uint32_t state = kSeed;
  const auto draw = [&state](int count) {  // linear congruential, high bits
    state = state * 1664525U + 1013904223U;
    return static_cast<int>((static_cast<std::uint64_t>(state) * static_cast<unsigned>(count)) >>
                            32);
  };
  const int half = samples.size() / 2;
  for (int iteration = 0; iteration < kRansacIterations; ++iteration) {
    // One sample from each half: a longer baseline gives a better line.
    const Sample p = samples[draw(half)];
    const Sample q = samples[half + draw(samples.size() - half)];
    if (q.t - p.t < 0.1) continue;
    InverseDepth model;
    model.b = (q.rho - p.rho) / (q.t - p.t);
    model.a = p.rho - model.b * p.t;
    const double score = model.Residuals(samples).square().min(limit).sum();
    if (score < best_score) {
      best_score = score;
      best = model;
    }
  }
  return best;
}

// Performs one weighted least squares step over the inliers of fit->model. Returns false if they do
// not determine it. Neighbouring pixels have correlated noise: the four at one position count as
// one measurement in the covariance.
bool Solve(const Samples& samples, Slope slope, Fit* fit) {
  const Column weights = (fit->model.Residuals(samples).abs() <= kInlierSigmas)
                             .select(samples.inverse_sigma().square(), 0.0);
  const Column along = weights * samples.t();
  Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
  Eigen::Vector3d y = Eigen::Vector3d::Zero();
  N(0, 0) = weights.sum();
  N(0, 1) = N(1, 0) = along.sum();
  N(1, 1) = (along * samples.t()).sum();
  y[0] = (weights * samples.rho()).sum();
  y[1] = (along * samples.rho()).sum();
  if (slope == Slope::kFitted) {
    const Column across = weights * samples.w();
    N(0, 2) = N(2, 0) = across.sum();
    N(1, 2) = N(2, 1) = (along * samples.w()).sum();
    N(2, 2) = (across * samples.w()).sum();
    y[2] = (across * samples.rho()).sum();
  }
  const double scale = N(0, 0);
  if (slope == Slope::kZero) N(2, 2) = scale;                           // its row is zero: c = 0
  if (!(N.determinant() > 1e-6 * scale * scale * scale)) return false;  // all at one position
  const Eigen::Matrix3d inverse = N.inverse();
  const Eigen::Vector3d x = inverse * y;
  fit->model = {x[0], x[1], x[2]};
  fit->covariance = 2.0 * kPixelsPerSide * inverse.topLeftCorner<2, 2>();
  return true;
}

Fit Refine(const Samples& samples, const InverseDepth& model, Slope slope) {
  constexpr int kRounds = 2;
  Fit fit;
  fit.model = model;
  for (int round = 0; round < kRounds; ++round) {
    if (!Solve(samples, slope, &fit)) return Fit();
  }
  const Column residuals = fit.model.Residuals(samples);
  const auto fits = residuals.abs() <= kInlierSigmas;
  const auto inliers = static_cast<double>(fits.count());
  if (inliers == 0.0) return Fit();
  const double sum_sigmas = fits.select(residuals.square(), 0.0).sum();
  const Column metres = residuals / (samples.inverse_sigma() * samples.rho().square());
  const double sum = fits.select(metres.square(), 0.0).sum();
  fit.inlier_share = inliers / samples.size();
  fit.rms_sigmas = std::sqrt(sum_sigmas / inliers);
  fit.rms = std::sqrt(sum / inliers);
  return fit;
}

// Fits both sides as one plane, starting from the lines found on each (lines[0] at w < 0, lines[1]
// at w > 0).
Fit RefineTogether(const std::array<Samples, 2>& sides, const std::array<InverseDepth, 2>& lines) {
  constexpr double kMeanDistance = 0.5 * (1 + kPixelsPerSide);  // of a side's pixels, in w
  const InverseDepth &p = lines[0], &q = lines[1];
  const InverseDepth middle{0.5 * (p.a + q.a), 0.5 * (p.b + q.b),
                            (q.At(0.5) - p.At(0.5)) / (2.0 * kMeanDistance)};
  Samples both = sides[0];
  both.Add(sides[1]);
  return Refine(both, middle, Slope::kFitted);
}

bool IsGood(const Fit& fit) {
  return fit.inlier_share >= kMinInliers && fit.rms_sigmas <= kMaxRms;
}

// Whether one side is in front of the other, by more than three sigmas of a reading.
bool IsStep(const std::array<Fit, 2>& fits, const std::array<Samples, 2>& sides) {
  const double step = std::abs(fits[0].model.At(0.5) - fits[1].model.At(0.5));
  const double inverse_sigma =
      std::min(sides[0].inverse_sigma().mean(), sides[1].inverse_sigma().mean());
  return step * inverse_sigma > kInlierSigmas;
}

// Standard deviation of the depth at t: sigma_z = z^2 sigma_rho.
double DepthDeviation(const Fit& fit, double t) {
  const Eigen::Vector2d row(1.0, t);
  const double rho = fit.model.At(t);
  return std::sqrt(row.dot(fit.covariance * row)) / (rho * rho);
}

}  // namespace

std::optional<SegmentDepth> FitSegmentDepth(const LineSegment& segment, const cv::Mat& depth,
                                            const RgbdSensor& sensor, double min_measured,
                                            const cv::Mat& noise_factor) {
  const PinholeCamera& camera = sensor.camera;
  HIGHWALL_REQUIRE(
      depth.type() == CV_32FC1 && depth.cols == camera.width && depth.rows == camera.height,
      "FitSegmentDepth: the depth image must be CV_32FC1 of the camera's size");
  HIGHWALL_REQUIRE(segment.s.allFinite() && segment.e.allFinite(),
                   "FitSegmentDepth: the segment must be finite");
  HIGHWALL_REQUIRE(noise_factor.empty() ||
                       (noise_factor.type() == CV_32FC1 && noise_factor.size() == depth.size()),
                   "FitSegmentDepth: the noise factors must be CV_32FC1 of the depth image's size");
  if (segment.Length() < 1.0F) return std::nullopt;

  std::array<Samples, 2> sides;
  std::array<InverseDepth, 2> lines;
  std::array<bool, 2> measured{};
  for (std::size_t i = 0; i < 2; ++i) {
    sides[i] = Collect(segment, i == 0 ? -1 : 1, depth, sensor, noise_factor);
    measured[i] = sides[i].size() >= min_measured * kPixelsPerSide * kPositions;
    if (measured[i]) lines[i] = Ransac(sides[i]);
  }
  if (!measured[0] && !measured[1]) return std::nullopt;

  SegmentDepth result;
  const auto refined = [&](std::size_t i) { return Refine(sides[i], lines[i], Slope::kZero); };
  Fit fit;
  if (measured[0] && measured[1]) {
    fit = RefineTogether(sides, lines);
    if (!IsGood(fit)) {
      const std::array<Fit, 2> fits{refined(0), refined(1)};
      const Fit& nearer = fits[fits[1].model.At(0.5) > fits[0].model.At(0.5)];
      if (!IsGood(nearer)) return std::nullopt;
      // Of two sides of one surface that is noisier than stated, the nearer one is nearer by
      // chance: taking it would make every such line too near.
      result.depth_edge = fit.inlier_share < kMinInliers || IsStep(fits, sides);
      if (result.depth_edge) {
        fit = nearer;
      } else {
        fit.covariance *= fit.rms_sigmas * fit.rms_sigmas;
      }
    }
  } else {
    fit = refined(measured[1] ? 1 : 0);
    if (!IsGood(fit)) return std::nullopt;
  }
  const double rho_s = fit.model.At(0.0), rho_e = fit.model.At(1.0);
  if (std::min(rho_s, rho_e) * sensor.max_depth < 1.0) return std::nullopt;

  const PinholeCamera undistorted = camera.WithoutDistortion();
  result.p_C = undistorted.Unproject(segment.s.cast<double>(), 1.0 / rho_s);
  result.q_C = undistorted.Unproject(segment.e.cast<double>(), 1.0 / rho_e);
  result.sigma_p = DepthDeviation(fit, 0.0);
  result.sigma_q = DepthDeviation(fit, 1.0);
  result.inlier_share = fit.inlier_share;
  result.rms = fit.rms;
  return result;
}

}  // namespace highwall
