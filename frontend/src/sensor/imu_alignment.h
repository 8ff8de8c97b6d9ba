#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/trajectory.h>
#include <highwall/factors/imu_buffer.h>

namespace highwall {

// Linear least squares between the poses of a camera and the readings of an IMU, in which the
// matrix that takes readings to the camera's axes is free (docs/misconfiguration.md, IMU). A
// configuration is one value of the unknowns, so its residual follows from the same sums.

// Stamps of the IMU for stamps of the camera: t_imu = origin + rate (t_cam - origin) + offset.
struct ClockRelation {
  double rate = 1.0;
  double offset = 0.0;  // [s]
};

// Sums over rotations of the camera c and integrals of the gyroscope b: c = A b + d dt.
class GyroscopeFit {
 public:
  // Adds one turn [rad] of `duration` [s].
  void Add(const Eigen::Vector3d& camera, const Eigen::Vector3d& body, double duration);

  int size() const { return n_; }
  // Sum of the squared rotations of the camera about their mean rate [rad^2].
  double Signal() const;
  // Sum of the squared residuals [rad^2] with the bias that fits best.
  double Squared(const Eigen::Matrix3d& A) const;
  // Returns the A that fits best, among all matrices or all rotations.
  Eigen::Matrix3d Free() const;
  Eigen::Matrix3d Rotation() const;
  // The same of rotations, with a prior at the rotation A0: weight [rad^2] times the squared
  // distance of the matrices is added to the squared residuals.
  Eigen::Matrix3d RotationNear(const Eigen::Matrix3d& A0, double weight) const;
  // Variance of a component of a residual of Free(), at least that of good poses [rad^2].
  double Variance() const;

 private:
  // Sums about the mean rates: of b b^T and c b^T.
  Eigen::Matrix3d BodyBody() const;
  Eigen::Matrix3d CameraBody() const;

  int n_ = 0;
  double camera_camera_ = 0.0, time_time_ = 0.0;
  Eigen::Matrix3d body_body_ = Eigen::Matrix3d::Zero(), camera_body_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d camera_time_ = Eigen::Vector3d::Zero(), body_time_ = Eigen::Vector3d::Zero();
};

// Sums over changes of the camera's velocity y and the accelerometer's readings f:
//   y = sum w R_WC (A f + b) + g sum w + (change of the rate of R_WC) l
// with the lever arm l = R_CB p_BC and the bias b.
class AccelerometerFit {
 public:
  static constexpr int kUnknowns = 18;  // A row by row, l, g, b
  using Row = Eigen::Matrix<double, 3, kUnknowns>;

  // y [m/s]; weight: sum of w [s].
  void Add(const Eigen::Vector3d& y, const Row& X, double weight);

  int size() const { return n_; }
  // Sum of the squared changes of velocity about their mean [m^2/s^2].
  double Signal() const;
  // Sum of the squared residuals [m^2/s^2] of readings with these axes and this lever arm [m].
  // Gravity is free; what a calibration leaves open is estimated with priors: small rotations,
  // bias, and lever_sigma [m] for the lever arm.
  double Squared(const Eigen::Matrix3d& A, const Eigen::Vector3d& lever_arm,
                 double lever_sigma = 0.03) const;
  // Returns the unknowns near these axes and this lever arm that fit best.
  Eigen::Matrix<double, kUnknowns, 1> Unknowns(const Eigen::Matrix3d& A,
                                               const Eigen::Vector3d& lever_arm) const;
  // Returns the lever arm that fits best with these axes [m].
  Eigen::Vector3d LeverArm(const Eigen::Matrix3d& A) const;
  // The least sum of squares, with everything free.
  double FreeSquared() const;
  // Variance of a component of a residual of the free fit, at least that of good poses [m^2/s^2].
  double Variance() const;
  double mean_weight() const { return n_ > 0 ? weight_ / n_ : 0.0; }

 private:
  struct Solution {
    double squared = 0.0;
    Eigen::VectorXd x;
  };
  Solution Near(const Eigen::Matrix3d& A, const Eigen::Vector3d& lever_arm,
                double lever_sigma) const;
  Solution Solve(const Eigen::Matrix<double, kUnknowns, 1>& start, const Eigen::MatrixXd& basis,
                 const Eigen::VectorXd& sigma) const;

  int n_ = 0;
  double weight_ = 0.0, yy_ = 0.0;
  Eigen::Vector3d y_ = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, kUnknowns, kUnknowns> H_ =
      Eigen::Matrix<double, kUnknowns, kUnknowns>::Zero();
  Eigen::Matrix<double, kUnknowns, 1> v_ = Eigen::Matrix<double, kUnknowns, 1>::Zero();
};

// Poses T_WC of a camera and the readings around them.
class ImuAlignment {
 public:
  // poses: in order of their stamps [ns, camera's clock]. readings: in order of theirs. Readings
  // at the end of a range and steps above max_step [s] are not used.
  ImuAlignment(const Trajectory& poses, std::span<const ImuSample> readings, double max_step,
               double gyroscope_range = std::numeric_limits<double>::infinity(),
               double accelerometer_range = std::numeric_limits<double>::infinity());

  // Rotations over 0.1 s, one after the other.
  GyroscopeFit Gyroscope(const ClockRelation& clock) const;
  // Changes of velocity over 0.2 s, one per 0.1 s.
  AccelerometerFit Accelerometer(const ClockRelation& clock) const;
  // Leaves out the tenth of the rotations, and the fifth of the changes of velocity, that fit these
  // axes and this lever arm worst: a shock, or poses that failed, are no fault of the
  // configuration.
  void Trim(const Eigen::Matrix3d& A, const Eigen::Vector3d& lever_arm, const ClockRelation& clock);
  double duration() const;  // [s] of the poses
  // [s] In the middle of the poses, since the origin of ClockRelation, which is the first reading.
  double middle() const;

 private:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  // Returns the integrals of gyroscope and accelerometer between two stamps of the camera [s];
  // empty if readings are missing or saturated.
  std::optional<Vector6> Between(double begin, double end, const ClockRelation& clock) const;
  Vector6 IntegralAt(std::size_t after, double time) const;
  // Returns the index of the first pose at least `span` [s] after pose i, if the poses up to it
  // follow each other; otherwise the number of poses.
  std::size_t After(std::size_t i, double span) const;

  struct Turn {
    std::size_t pose = 0;  // where it begins
    Eigen::Vector3d camera, body;
    double duration = 0.0;
  };
  // Between a pose and the next one.
  struct Interval {
    bool usable = false;
    double middle = 0.0, duration = 0.0;                 // [s]
    Eigen::Matrix3d R_WC = Eigen::Matrix3d::Identity();  // in the middle, by the images
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();  // by the gyroscope, in C
    Eigen::Vector3d force = Eigen::Vector3d::Zero();     // mean reading [m/s^2]
  };
  struct Arc {
    std::size_t pose = 0;
    Eigen::Vector3d y;
    AccelerometerFit::Row X = AccelerometerFit::Row::Zero();
    double weight = 0.0;
  };
  std::vector<Turn> Turns(const ClockRelation& clock) const;
  std::vector<Arc> Arcs(const ClockRelation& clock) const;
  // How the camera turns is taken from the gyroscope, by the axes that fit the images best,
  // whatever is configured. An image's errors of rotation and position are those of a rotation
  // about what it sees: rotations of the images would explain the errors of the positions by a
  // lever arm as long as the depth.
  std::vector<Interval> Intervals(const ClockRelation& clock) const;
  // Of poses i < j < k; empty if readings are missing.
  std::optional<Arc> ArcOf(std::size_t i, std::size_t j, std::size_t k,
                           std::span<const Interval> intervals) const;

  struct CameraPose {
    double time = 0.0;  // [s] since the first reading
    Eigen::Matrix3d R_WC;
    Eigen::Vector3d p_WC;
    bool skips_turn = false, skips_arc = false;  // that begins here
  };
  std::vector<CameraPose> poses_;
  std::vector<double> times_;       // [s] of the readings since the first
  std::vector<Vector6> integrals_;  // up to each reading
  std::vector<int> bad_;            // number of unusable steps up to each reading
};

}  // namespace highwall
