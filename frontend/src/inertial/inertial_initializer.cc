#include "inertial/inertial_initializer.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>
#include <highwall/core/so3.h>
#include <highwall/factors/camera_pose.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/internal/median.h>

#include "inertial/imu_saturation.h"
#include "inertial/imu_vibration.h"

namespace highwall {
namespace {

constexpr double kImageInterval = 0.1;  // [s] between the images used
constexpr double kMinDuration = 1.0;    // [s] from the first of them to the last
constexpr double kMaxError = 20.0;      // chi-squared per degree of freedom

using Vector6 = Eigen::Matrix<double, 6, 1>;

struct Guess {
  double time_offset = 0.0;
  ImuBias bias = ImuBias::Zero();
  Pose T_BC;
};

// Body poses from the images' poses, and the IMU between them, for one guess of t_d and bias.
struct Motion {
  std::vector<Stamp> stamps;  // of the IMU's clock
  std::vector<Pose> T_WB;
  std::vector<ImuPreintegration> imu;  // one less

  // Adds an image. T_WC: its pose.
  void Add(Stamp image, const Pose& T_WC, const Guess& guess) {
    stamps.push_back(image + FromSeconds(guess.time_offset));
    T_WB.push_back(T_WC * guess.T_BC.Inverse());
  }
  void Integrate(const ImuBuffer& readings, const Guess& guess, const ImuCalibration& calibration) {
    for (std::size_t i = 0; i + 1 < stamps.size(); ++i) {
      const auto interval = readings.Between(stamps[i], stamps[i + 1]);
      const ImuNoise shaken = ShakenNoise(calibration.noise, interval->samples);
      const ImuNoise noise = SaturatedNoise(shaken, interval->samples, calibration);
      imu.emplace_back(interval->samples, guess.bias, ImuPreintegrationOptions{.noise = noise});
    }
  }
};

// Returns the mean gravity over the whole motion that explains the displacements of the body.
Eigen::Vector3d MeanGravity(const Motion& motion) {
  const std::size_t n = motion.T_WB.size();
  const auto velocity = [&](std::size_t i) -> Eigen::Vector3d {
    return (motion.T_WB[i + 1].p() - motion.T_WB[i].p()) / motion.imu[i].delta().duration;
  };
  // Between the middles of the first and the last interval.
  Eigen::Vector3d change = velocity(n - 2) - velocity(0);
  double seconds = 0.0;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double share = i == 0 || i + 2 == n ? 0.5 : 1.0;
    change -= share * (motion.T_WB[i].q() * motion.imu[i].delta().v);
    seconds += share * motion.imu[i].delta().duration;
  }
  return change / seconds;
}

// Least-squares problem for one guess.
class Problem {
 public:
  Problem(const Motion& motion, const Guess& guess, const UnitDirection& gravity) {
    gravity_ = graph_.AddVariable(gravity);
    time_offset_ = graph_.AddVariable(guess.time_offset);
    const std::size_t n = motion.T_WB.size();
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t k = std::min(i, n - 2);
      poses_.push_back(graph_.AddVariable(motion.T_WB[i]));
      velocities_.push_back(graph_.AddVariable(Eigen::Vector3d(
          (motion.T_WB[k + 1].p() - motion.T_WB[k].p()) / motion.imu[k].delta().duration)));
      biases_.push_back(graph_.AddVariable(guess.bias));
    }
    for (std::size_t i = 0; i + 1 < n; ++i) {
      graph_.AddFactor(std::make_unique<ImuGravityFactor>(motion.imu[i]), poses_[i], velocities_[i],
                       biases_[i], poses_[i + 1], velocities_[i + 1], biases_[i + 1], gravity_);
    }
    // Pose, velocity and bias of each image, gravity, t_d.
    dof_ = 15 * static_cast<int>(n - 1) - (15 * static_cast<int>(n) + 2 + 1);
  }

  // Makes the extrinsics an unknown with the initial value `guess` and a prior at T_BC. To be
  // called before AddImage().
  void AddExtrinsics(const Pose& T_BC, const Eigen::Matrix<double, 6, 1>& sigma,
                     const Pose& guess) {
    extrinsics_ = {graph_.AddVariable(guess), graph_.AddVariable(1.0)};
    graph_.Fix(extrinsics_->scale);
    graph_.AddFactor(std::make_unique<PosePrior>(
                         T_BC, Eigen::Matrix<double, 6, 6>(sigma.cwiseInverse().asDiagonal())),
                     extrinsics_->T_BC);
  }
  void AddImage(std::size_t i, const VisualPose& visual, const Pose& T_BC,
                const Eigen::Vector3d& omega_B, double t_d_state) {
    if (extrinsics_) {
      graph_.AddFactor(std::make_unique<ExtrinsicCameraPose>(visual.T_WC, visual.sqrt_information,
                                                             omega_B, t_d_state),
                       poses_[i], velocities_[i], time_offset_, extrinsics_->T_BC,
                       extrinsics_->scale);
    } else {
      graph_.AddFactor(std::make_unique<CameraPose>(visual.T_WC, visual.sqrt_information, T_BC,
                                                    omega_B, t_d_state),
                       poses_[i], velocities_[i], time_offset_);
    }
    // A row of zeros belongs to an unobservable direction.
    dof_ += static_cast<int>((visual.sqrt_information.array() != 0.0).rowwise().any().count());
  }
  void AddPriors(const InertialInitializerOptions& options, double time_offset, bool free) {
    Eigen::Matrix<double, 6, 1> sigma;
    sigma << Eigen::Vector3d::Constant(options.gyroscope_bias_sigma),
        Eigen::Vector3d::Constant(options.accelerometer_bias_sigma);
    graph_.AddFactor(
        std::make_unique<VectorPrior<6>>(ImuBias::Zero(), sigma.cwiseInverse().asDiagonal()),
        biases_.front());
    dof_ += 6 + 1;  // a fixed t_d is no unknown
    if (free) {
      using Offset = Eigen::Matrix<double, 1, 1>;
      graph_.AddFactor(
          std::make_unique<VectorPrior<1>>(Offset::Constant(time_offset),
                                           Offset::Constant(1.0 / options.time_offset_sigma)),
          time_offset_);
    } else {
      graph_.Fix(time_offset_);
    }
  }

  bool Solve() { return graph_.Solve({.max_iterations = 20}).IsUsable(); }
  double Error() const { return 2.0 * graph_.Cost() / std::max(dof_, 1); }
  // T_BC: its value if it is known.
  Guess Latest(const Pose& T_BC) const {
    return {graph_.Value(time_offset_), graph_.Value(biases_.back()),
            extrinsics_ ? graph_.Value(extrinsics_->T_BC) : T_BC};
  }

  // Returns empty if the images leave a direction unobservable throughout.
  std::optional<InertialPrior> Result(Stamp stamp) const {
    std::vector<VariableId> ids = {poses_.back(), velocities_.back(), biases_.back(), gravity_,
                                   time_offset_};
    if (extrinsics_) ids.push_back(extrinsics_->T_BC);
    const std::optional<Eigen::MatrixXd> covariance = graph_.Covariance(ids);
    if (!covariance) return std::nullopt;
    InertialPrior result;
    result.estimate.stamp = stamp;
    result.estimate.state = {graph_.Value(poses_.back()), graph_.Value(velocities_.back())};
    result.estimate.bias = graph_.Value(biases_.back());
    result.gravity_W = graph_.Value(gravity_);
    result.time_offset = graph_.Value(time_offset_);
    if (extrinsics_) result.T_BC = graph_.Value(extrinsics_->T_BC);
    result.SetJoint(*covariance);
    return result;
  }

 private:
  FactorGraph graph_;
  Variable<UnitDirection> gravity_;
  Variable<double> time_offset_;
  struct Extrinsics {
    Variable<Pose> T_BC;
    Variable<double> scale;  // of the depth: fixed
  };
  std::optional<Extrinsics> extrinsics_;  // if they are unknowns
  std::vector<Variable<Pose>> poses_;
  std::vector<Variable<Eigen::Vector3d>> velocities_;
  std::vector<Variable<ImuBias>> biases_;
  int dof_ = 0;  // rows less unknowns
};

}  // namespace

const char* ToString(InitializationStatus status) {
  switch (status) {
    case InitializationStatus::kTooShort:
      return "too short";
    case InitializationStatus::kNoImu:
      return "no readings";
    case InitializationStatus::kUncertain:
      return "uncertain";
    case InitializationStatus::kWrongGravity:
      return "wrong gravity";
    case InitializationStatus::kInconsistent:
      return "inconsistent";
    case InitializationStatus::kReady:
      return "ready";
  }
  return "unknown";
}

namespace {

// Returns the median norm of the accelerometer's readings [m/s^2]; 0 without readings.
double MedianNorm(const ImuBuffer& imu, Stamp begin, Stamp end) {
  const auto interval = imu.Between(begin, end);
  if (!interval) return 0.0;
  std::vector<double> norms;
  for (const ImuSample& sample : interval->samples) norms.push_back(sample.accelerometer.norm());
  return UpperMedian(std::move(norms));
}

}  // namespace

Eigen::Vector3d RateAt(const ImuBuffer& imu, Stamp stamp, const ImuBias& bias) {
  constexpr Stamp kHalf = 10'000'000;
  if (imu.empty() || imu.newest() <= stamp - kHalf) return Eigen::Vector3d::Zero();
  const auto interval = imu.Between(stamp - kHalf, std::min(stamp + kHalf, imu.newest()));
  if (!interval) return Eigen::Vector3d::Zero();
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const ImuSample& sample : interval->samples) mean += sample.gyroscope;
  return mean / static_cast<double>(interval->samples.size()) - bias.head<3>();
}

InertialInitializer::InertialInitializer(const ImuCalibration& calibration,
                                         const InertialInitializerOptions& options,
                                         bool free_time_offset,
                                         const std::optional<Vector6>& extrinsics_sigma,
                                         const InitializationCriteria& criteria)
    : calibration_(calibration),
      options_(options),
      criteria_(criteria),
      free_time_offset_(free_time_offset),
      extrinsics_sigma_(extrinsics_sigma) {
  calibration_.Validate();
  options_.Validate();
}

bool InertialInitializer::Add(Stamp stamp, const VisualPose& visual) {
  // Half a millisecond of jitter in the stamps must not cost an image.
  if (!images_.empty() && ToSeconds(stamp - images_.back().stamp) < kImageInterval - 5e-4) {
    return false;
  }
  images_.push_back({stamp, visual});
  while (ToSeconds(stamp - images_.front().stamp) > criteria_.max_duration) images_.pop_front();
  return true;
}

void InertialInitializer::MoveMap(const Pose& T_new_old) {
  for (Image& image : images_) image.visual = Moved(image.visual, T_new_old);
}

std::size_t InertialInitializer::FirstImage(const ImuBuffer& imu, double time_offset) const {
  const Stamp offset = FromSeconds(time_offset);
  for (std::size_t i = images_.size(); i-- > 1;) {
    const auto interval = imu.Between(images_[i - 1].stamp + offset, images_[i].stamp + offset);
    if (!interval || interval->HasGap()) return i;
  }
  return 0;
}

double InertialInitializer::MaxGravitySigma() const {
  const double turn = extrinsics_sigma_ ? extrinsics_sigma_->tail<3>().maxCoeff() : 0.0;
  return std::hypot(criteria_.max_gravity_sigma, turn);
}

InitializationReport InertialInitializer::Solve(const ImuBuffer& imu) const {
  InitializationReport report;
  const auto is_short = [&](std::size_t first) {
    if (images_.size() < first + 3) return true;
    report.duration = ToSeconds(images_.back().stamp - images_[first].stamp);
    return report.duration < kMinDuration;
  };
  if (is_short(0)) return report;

  Guess guess{calibration_.time_offset, ImuBias::Zero(), calibration_.T_BC};
  // The offset changes the instants at which the readings are cut, and the biases their integrals.
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    const std::size_t first = FirstImage(imu, guess.time_offset);
    if (is_short(first)) {
      report.status = InitializationStatus::kNoImu;
      return report;
    }
    Motion motion;
    for (std::size_t i = first; i < images_.size(); ++i) {
      motion.Add(images_[i].stamp, images_[i].visual.T_WC, guess);
    }
    motion.Integrate(imu, guess, calibration_);
    const Eigen::Vector3d gravity = MeanGravity(motion);
    report.gravity_norm = gravity.norm();
    if (std::abs(report.gravity_norm / kStandardGravity - 1.0) > kMaxGravityError) {
      report.status = InitializationStatus::kWrongGravity;
      report.reading_norm = MedianNorm(imu, motion.stamps.front(), motion.stamps.back());
      return report;
    }
    Problem problem(motion, guess, UnitDirection(gravity));
    if (extrinsics_sigma_) {
      problem.AddExtrinsics(calibration_.T_BC, *extrinsics_sigma_, guess.T_BC);
    }
    for (std::size_t i = 0; i < motion.stamps.size(); ++i) {
      problem.AddImage(i, images_[first + i].visual, calibration_.T_BC,
                       RateAt(imu, motion.stamps[i], guess.bias), guess.time_offset);
    }
    problem.AddPriors(options_, calibration_.time_offset, free_time_offset_);
    report.status = InitializationStatus::kInconsistent;
    if (!problem.Solve()) return report;
    guess = problem.Latest(guess.T_BC);
    if (round + 1 < kRounds) continue;
    report.error = problem.Error();
    report.estimate = problem.Result(motion.stamps.back());
  }
  if (!report.estimate) {
    report.status = InitializationStatus::kUncertain;
    report.gravity_sigma = M_PI;
    return report;
  }
  report.gravity_sigma = report.estimate->gravity_sigma() * std::sqrt(std::max(1.0, report.error));
  if (report.error > kMaxError) return report;
  // Images significantly worse than their stated covariance need a longer duration.
  constexpr double kChance = 2.0;
  const double factor = report.error > kChance ? std::sqrt(report.error) : 1.0;
  const double wanted = std::min(factor * kMinDuration, criteria_.max_duration - kImageInterval);
  constexpr double kSlack = 1e-3;  // [s] for rounded stamps
  report.status = report.duration < wanted - kSlack || report.gravity_sigma > MaxGravitySigma()
                      ? InitializationStatus::kUncertain
                      : InitializationStatus::kReady;
  return report;
}

}  // namespace highwall
