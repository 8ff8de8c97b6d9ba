#include <highwall/frontend/segment_depth.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <highwall/core/error.h>

namespace highwall {
namespace {

constexpr int kMaxSamples = 64;
constexpr int kPixelsPerSide = 2;

struct Sample {
  double t;              // along the segment, 0 at s, 1 at e
  double rho;            // [1/m] inverse depth
  double inverse_sigma;  // [m] of rho
};

// Samples on the stack: this runs for every segment of every frame.
class Samples {
 public:
  void Add(const Sample& sample) { data_[static_cast<std::size_t>(size_++)] = sample; }
  void Add(const Samples& other) {
    for (const Sample& sample : other) Add(sample);
  }
  int size() const { return size_; }
  const Sample* begin() const { return data_.data(); }
  const Sample* end() const { return data_.data() + size_; }
  const Sample& operator[](int i) const { return data_[static_cast<std::size_t>(i)]; }

 private:
  std::array<Sample, 2 * kPixelsPerSide * kMaxSamples> data_;
  int size_ = 0;
};

// rho(t) = a + b t.
struct InverseDepthLine {
  double a = 0.0, b = 0.0;

  double At(double t) const { return a + b * t; }
  // In sigmas.
  double Residual(const Sample& sample) const {
    return (At(sample.t) - sample.rho) * sample.inverse_sigma;
  }
};

struct Fit {
  InverseDepthLine line;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of (a, b)
  double inlier_share = 0.0;
  double rms_sigmas = 0.0;
  double rms = 0.0;  // [m]
};

// Depth pixels on one side (-1 or 1) of the segment.
Samples Collect(const LineSegment& segment, int side, const cv::Mat& depth,
                const PinholeCamera& camera, const SegmentDepthOptions& options) {
  Samples samples;
  const Eigen::Vector2d s = segment.s.cast<double>(), d = segment.e.cast<double>() - s;
  const Eigen::Vector2d n = Eigen::Vector2d(d.y(), -d.x()).normalized() * side;
  const bool distorted = camera.HasDistortion();
  for (int i = 0; i < options.samples; ++i) {
    const double t = (i + 0.5) / options.samples;
    for (int k = 1; k <= kPixelsPerSide; ++k) {
      Eigen::Vector2d uv = s + t * d + (k * options.half_width / kPixelsPerSide) * n;
      if (distorted) {
        const Eigen::Vector2d m =
            camera.Distort({(uv.x() - camera.cx) / camera.fx, (uv.y() - camera.cy) / camera.fy});
        uv = {camera.fx * m.x() + camera.cx, camera.fy * m.y() + camera.cy};
      }
      if (!camera.Contains(uv)) continue;
      const double z =
          depth.at<float>(static_cast<int>(uv.y() + 0.5), static_cast<int>(uv.x() + 0.5));
      if (!(z >= options.min_depth && z <= options.max_depth)) continue;  // also NaN
      samples.Add({t, 1.0 / z, z * z / options.sigma(z)});
    }
  }
  return samples;
}

// The best line through two of the samples by the truncated squared residuals.
InverseDepthLine Ransac(const Samples& samples, const SegmentDepthOptions& options) {
  const double limit = options.inlier_sigmas * options.inlier_sigmas;
  InverseDepthLine best;
  double best_score = std::numeric_limits<double>::infinity();
  std::uint32_t state = options.seed;
  const auto draw = [&state](int count) {  // linear congruential, high bits
    state = state * 1664525U + 1013904223U;
    return static_cast<int>((static_cast<std::uint64_t>(state) * static_cast<unsigned>(count)) >>
                            32);
  };
  for (int iteration = 0; iteration < options.ransac_iterations; ++iteration) {
    // One from each half: a longer base gives a better line.
    const int half = samples.size() / 2;
    const Sample& p = samples[draw(half)];
    const Sample& q = samples[half + draw(samples.size() - half)];
    if (q.t - p.t < 0.1) continue;
    InverseDepthLine line;
    line.b = (q.rho - p.rho) / (q.t - p.t);
    line.a = p.rho - line.b * p.t;
    double score = 0.0;
    for (const Sample& sample : samples) {
      const double residual = line.Residual(sample);
      score += std::min(residual * residual, limit);
    }
    if (score < best_score) {
      best_score = score;
      best = line;
    }
  }
  return best;
}

// Weighted least squares over the inliers of `line`, twice. Neighbouring pixels share their noise:
// the four of one place count as one measurement in the covariance.
Fit Refine(const Samples& samples, InverseDepthLine line, const SegmentDepthOptions& options) {
  constexpr int kRounds = 2;
  Fit fit;
  for (int round = 0; round < kRounds; ++round) {
    double w0 = 0.0, w1 = 0.0, w2 = 0.0, y0 = 0.0, y1 = 0.0;
    for (const Sample& sample : samples) {
      if (std::abs(line.Residual(sample)) > options.inlier_sigmas) continue;
      const double weight = sample.inverse_sigma * sample.inverse_sigma;
      w0 += weight;
      w1 += weight * sample.t;
      w2 += weight * sample.t * sample.t;
      y0 += weight * sample.rho;
      y1 += weight * sample.t * sample.rho;
    }
    const double determinant = w0 * w2 - w1 * w1;
    if (!(determinant > 1e-6 * w0 * w0)) return fit;  // all at one place
    line = {(w2 * y0 - w1 * y1) / determinant, (w0 * y1 - w1 * y0) / determinant};
    fit.covariance << w2, -w1, -w1, w0;
    fit.covariance *= 2.0 * kPixelsPerSide / determinant;
  }
  fit.line = line;
  int inliers = 0;
  double sum_sigmas = 0.0, sum = 0.0;
  for (const Sample& sample : samples) {
    const double residual = line.Residual(sample);
    if (std::abs(residual) > options.inlier_sigmas) continue;
    ++inliers;
    sum_sigmas += residual * residual;
    const double metres = 1.0 / line.At(sample.t) - 1.0 / sample.rho;
    sum += metres * metres;
  }
  if (inliers == 0) return fit;
  fit.inlier_share = static_cast<double>(inliers) / samples.size();
  fit.rms_sigmas = std::sqrt(sum_sigmas / inliers);
  fit.rms = std::sqrt(sum / inliers);
  return fit;
}

bool IsGood(const Fit& fit, const SegmentDepthOptions& options) {
  return fit.inlier_share >= options.min_inliers && fit.rms_sigmas <= options.max_rms;
}

// Standard deviation of the depth at t: sigma_z = z^2 sigma_rho.
double DepthDeviation(const Fit& fit, double t) {
  const Eigen::Vector2d row(1.0, t);
  const double rho = fit.line.At(t);
  return std::sqrt(row.dot(fit.covariance * row)) / (rho * rho);
}

}  // namespace

void SegmentDepthOptions::Validate() const {
  HIGHWALL_REQUIRE(samples >= 4 && samples <= kMaxSamples,
                   "SegmentDepthOptions::samples must be in [4, 64]");
  HIGHWALL_REQUIRE(half_width > 0.0, "SegmentDepthOptions::half_width must be positive");
  HIGHWALL_REQUIRE(min_depth > 0.0, "SegmentDepthOptions::min_depth must be positive");
  HIGHWALL_REQUIRE(max_depth > min_depth, "SegmentDepthOptions::max_depth must exceed min_depth");
  HIGHWALL_REQUIRE(min_valid > 0.0 && min_valid <= 1.0,
                   "SegmentDepthOptions::min_valid must be in (0, 1]");
  HIGHWALL_REQUIRE(min_inliers > 0.0 && min_inliers <= 1.0,
                   "SegmentDepthOptions::min_inliers must be in (0, 1]");
  HIGHWALL_REQUIRE(inlier_sigmas > 0.0, "SegmentDepthOptions::inlier_sigmas must be positive");
  HIGHWALL_REQUIRE(max_rms > 0.0, "SegmentDepthOptions::max_rms must be positive");
  HIGHWALL_REQUIRE(ransac_iterations > 0,
                   "SegmentDepthOptions::ransac_iterations must be positive");
  HIGHWALL_REQUIRE(sigma.base > 0.0 && sigma.quadratic >= 0.0,
                   "SegmentDepthOptions::sigma must be positive at every depth");
}

std::optional<SegmentDepth> FitSegmentDepth(const LineSegment& segment, const cv::Mat& depth,
                                            const PinholeCamera& camera,
                                            const SegmentDepthOptions& options) {
  options.Validate();
  HIGHWALL_REQUIRE(
      depth.type() == CV_32FC1 && depth.cols == camera.width && depth.rows == camera.height,
      "FitSegmentDepth: the depth image must be CV_32FC1 of the camera's size");
  HIGHWALL_REQUIRE(segment.s.allFinite() && segment.e.allFinite(),
                   "FitSegmentDepth: segment not finite");
  if (segment.Length() < 1.0F) return std::nullopt;

  std::array<Samples, 2> sides;
  std::array<Fit, 2> fits;
  std::array<bool, 2> measured{};
  for (std::size_t i = 0; i < 2; ++i) {
    sides[i] = Collect(segment, i == 0 ? -1 : 1, depth, camera, options);
    measured[i] = sides[i].size() >= options.min_valid * kPixelsPerSide * options.samples;
    if (measured[i]) fits[i] = Refine(sides[i], Ransac(sides[i], options), options);
  }
  if (!measured[0] && !measured[1]) return std::nullopt;

  SegmentDepth result;
  Fit fit;
  if (measured[0] && measured[1]) {
    Samples both = sides[0];
    both.Add(sides[1]);
    const bool nearer = fits[1].line.At(0.5) > fits[0].line.At(0.5);
    fit = Refine(both, fits[nearer].line, options);
    if (!IsGood(fit, options)) {
      fit = fits[nearer];
      result.depth_edge = true;
    }
  } else {
    fit = fits[measured[1]];
  }
  if (!IsGood(fit, options)) return std::nullopt;
  const double rho_s = fit.line.At(0.0), rho_e = fit.line.At(1.0);
  if (std::min(rho_s, rho_e) * options.max_depth < 1.0) return std::nullopt;

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
