#include <highwall/frontend/calibration/allan_deviation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>

#include <highwall/core/error.h>
#include <highwall/internal/quiet_glog.h>
#include <highwall/internal/require.h>

namespace highwall {
namespace {

constexpr double kChi2Of95 = 3.841;  // one degree of freedom

// Returns the equivalent degrees of freedom of a squared deviation from n + 1 integrated readings
// with averaging factor m: the smaller of those for white noise and for a random walk. Riley, table
// 5.
double DegreesOfFreedom(double n, double m) {
  const double N = n + 1.0;
  const double white =
      (3.0 * (N - 1.0) / (2.0 * m) - 2.0 * (N - 2.0) / N) * 4.0 * m * m / (4.0 * m * m + 5.0);
  const double walk = (N - 2.0) / m * ((N - 1.0) * (N - 1.0) - 3.0 * m * (N - 1.0) + 4.0 * m * m) /
                      ((N - 3.0) * (N - 3.0));
  return std::min(white, walk);
}

// Sum and number of the squared second differences of a stretch.
struct Differences {
  double sum = 0.0;
  std::size_t count = 0;
};

Differences SecondDifferences(const std::vector<double>& integrated, std::size_t m) {
  Differences differences;
  for (std::size_t k = 0; k + 2 * m < integrated.size(); ++k) {
    const double d = integrated[k + 2 * m] - 2.0 * integrated[k + m] + integrated[k];
    differences.sum += d * d;
    ++differences.count;
  }
  return differences;
}

// Integrates the readings in units of the step, after subtracting their mean to keep precision.
std::vector<double> Integrated(const std::vector<double>& readings) {
  double mean = 0.0;
  for (const double reading : readings) {
    HIGHWALL_REQUIRE(std::isfinite(reading), "AllanDeviation: the readings must be finite");
    mean += reading;
  }
  mean /= static_cast<double>(std::max<std::size_t>(readings.size(), 1));
  std::vector<double> integrated = {0.0};
  integrated.reserve(readings.size() + 1);
  for (const double reading : readings) integrated.push_back(integrated.back() + reading - mean);
  return integrated;
}

// Returns the variances at tau of white noise, flicker noise and random walk of density 1: Eq. 2.
using Shares = std::array<double, 3>;
Shares UnitVariances(double tau) {
  return {1.0 / tau, 2.0 * std::log(2.0) / M_PI, tau / 3.0};
}

// Signed square root of the deviance of a variance s that is chi-square distributed about the
// model's: Eq. 3. Parameters: logarithms of the three squared densities. The square of the residual
// is twice the negative log-likelihood up to a constant, so least squares is maximum likelihood.
class Deviance final : public ceres::SizedCostFunction<1, 1, 1, 1> {
 public:
  Deviance(const AllanPoint& point, double freedom)
      : shares_(UnitVariances(point.tau)),
        variance_(point.deviation * point.deviation),
        freedom_(freedom) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    std::array<double, 3> parts{};
    double model = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      parts[i] = shares_[i] * std::exp(parameters[i][0]);
      model += parts[i];
    }
    // d = x root, d^2 = x - log(1 + x); by its series where the difference would cancel.
    const double x = variance_ / model - 1.0;
    const double root = std::abs(x) < 1e-4 ? std::sqrt(0.5 - x / 3.0 + 0.25 * x * x)
                                           : std::sqrt(x - std::log1p(x)) / std::abs(x);
    residuals[0] = std::sqrt(freedom_) * x * root;
    if (jacobians == nullptr) return true;
    // dd/dx = x / (1 + x) / (2 d), dx/dlog(part) = -(1 + x) part / model
    const double slope = -std::sqrt(freedom_) / (2.0 * root * model);
    for (std::size_t i = 0; i < 3; ++i) {
      if (jacobians[i] == nullptr) continue;
      jacobians[i][0] = slope * parts[i];
    }
    return true;
  }

 private:
  const Shares shares_;
  const double variance_, freedom_;
};

// Maximum-likelihood fit of three densities, and profile likelihood of each of them.
class AllanFit {
 public:
  AllanFit(std::span<const AllanPoint> points, const AllanFitOptions& options) {
    for (const AllanPoint& point : points) {
      // Octaves overlap, so each counts a third; then the intervals of random walks also have a
      // coverage of 95 % (allan_deviation_test.cc). The logarithm of a squared deviation has the
      // variance 2 / freedom by chance, and 4 e^2 by an error e of the model.
      const double freedom =
          1.0 / (3.0 / point.freedom + 2.0 * options.model_error * options.model_error);
      problem_.AddResidualBlock(new Deviance(point, freedom), nullptr, &log_[0], &log_[1],
                                &log_[2]);
      for (std::size_t i = 0; i < 3; ++i) {
        // Squared density that alone explains the point: none can be larger, except by chance.
        const double alone = point.deviation * point.deviation / UnitVariances(point.tau)[i];
        highest_[i] = std::min(highest_[i], alone);
      }
    }
    for (std::size_t i = 0; i < 3; ++i) {
      problem_.SetParameterLowerBound(&log_[i], 0, std::log(highest_[i]) - kRange);
      problem_.SetParameterUpperBound(&log_[i], 0, std::log(highest_[i]) + kRange);
    }
    cost_ = Solve(std::nullopt);
    best_ = log_;
  }

  double Value(std::size_t i) const {
    return std::exp(best_[i]) < kNothing * highest_[i] ? 0.0 : std::exp(0.5 * best_[i]);
  }

  // Returns the interval of Value(i): its ends are where the deviance exceeds the minimum by the 95
  // % quantile.
  NoiseDensity Interval(std::size_t i) {
    NoiseDensity density{.value = Value(i)};
    const double top = std::log(highest_[i]);
    const double from = density.value > 0.0 ? best_[i] : top + std::log(kNothing);
    density.high = std::exp(0.5 * Cross(i, from, top + kRange));
    const double bottom = top + std::log(kNothing);
    if (density.value > 0.0 && Excess(i, bottom) > 0.0) {
      density.low = std::exp(0.5 * Cross(i, from, bottom));
    }
    return density;
  }

 private:
  static constexpr double kRange = 30.0;    // of a logarithm: thirteen orders of magnitude
  static constexpr double kNothing = 1e-8;  // of the largest possible variance

  // Minimizes the cost from an initial third of the variance for each component, with log_[fixed]
  // held constant if given.
  double Solve(std::optional<std::size_t> fixed) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (i == fixed) continue;
      log_[i] = std::log(highest_[i] / 3.0);
    }
    if (fixed) problem_.SetParameterBlockConstant(&log_[*fixed]);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.max_num_iterations = 200;
    options.function_tolerance = 1e-12;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    const internal::QuietGlog quiet;
    ceres::Solve(options, &problem_, &summary);
    if (fixed) problem_.SetParameterBlockVariable(&log_[*fixed]);
    return summary.final_cost;
  }

  // Returns twice the increase of the cost above the minimum, minus the 95 % quantile.
  double Excess(std::size_t i, double value) {
    log_[i] = value;
    return 2.0 * (Solve(i) - cost_) - kChi2Of95;
  }

  // Finds the zero of Excess() between `inside` and `outside` by bisection.
  double Cross(std::size_t i, double inside, double outside) {
    for (int step = 0; step < 24; ++step) {
      const double middle = 0.5 * (inside + outside);
      (Excess(i, middle) > 0.0 ? outside : inside) = middle;
    }
    return 0.5 * (inside + outside);
  }

  ceres::Problem problem_;
  std::array<double, 3> log_{};  // of the squared densities: white, flicker, random walk
  std::array<double, 3> best_{};
  std::array<double, 3> highest_ = {HUGE_VAL, HUGE_VAL, HUGE_VAL};
  double cost_ = 0.0;
};

}  // namespace

void AllanFitOptions::Validate() const {
  RequireNotNegativeFinite(min_tau, "AllanFitOptions::min_tau");
  RequireNotNegativeFinite(model_error, "AllanFitOptions::model_error");
}

std::vector<AllanPoint> AllanDeviation(std::span<const std::vector<double>> stretches,
                                       double step) {
  RequirePositiveFinite(step, "AllanDeviation: step");
  std::vector<std::vector<double>> integrated;
  std::size_t longest = 0;
  for (const std::vector<double>& stretch : stretches) {
    integrated.push_back(Integrated(stretch));
    longest = std::max(longest, stretch.size());
  }
  std::vector<AllanPoint> curve;
  for (std::size_t m = 1; 3 * m <= longest; m *= 2) {
    Differences all;
    double freedom = 0.0;
    for (const std::vector<double>& stretch : integrated) {
      if (stretch.size() <= 3 * m) continue;
      const Differences own = SecondDifferences(stretch, m);
      all.sum += own.sum;
      all.count += own.count;
      freedom += DegreesOfFreedom(static_cast<double>(stretch.size() - 1), static_cast<double>(m));
    }
    const double variance =
        all.sum / (2.0 * static_cast<double>(m * m) * static_cast<double>(all.count));  // Eq. 1
    curve.push_back({static_cast<double>(m) * step, std::sqrt(variance), freedom});
  }
  return curve;
}

double ModelledAllanDeviation(const NoiseDensities& densities, double tau) {
  const Shares unit = UnitVariances(tau);
  const auto square = [](const NoiseDensity& d) { return d.value * d.value; };
  return std::sqrt(unit[0] * square(densities.white) + unit[1] * square(densities.instability) +
                   unit[2] * square(densities.walk));
}

std::optional<NoiseDensities> FitAllanCurve(std::span<const AllanPoint> curve,
                                            const AllanFitOptions& options) {
  options.Validate();
  std::vector<AllanPoint> used;
  for (const AllanPoint& point : curve) {
    if (point.tau >= options.min_tau && point.deviation > 0.0) used.push_back(point);
  }
  if (used.size() < 3) return std::nullopt;
  AllanFit fit(used, options);
  return NoiseDensities{
      .white = fit.Interval(0), .instability = fit.Interval(1), .walk = fit.Interval(2)};
}

}  // namespace highwall
