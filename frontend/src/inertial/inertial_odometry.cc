#include <highwall/frontend/inertial/inertial_odometry.h>

#include "inertial/inertial_odometry_impl.h"

namespace highwall {

InertialOdometry::InertialOdometry(const ImuCalibration& calibration,
                                   const InertialOptions& options,
                                   const std::optional<MeasurementModel>& model, bool background,
                                   RunProfile* profile)
    : impl_(std::make_unique<Impl>(calibration, options, model, background, profile)) {}

InertialOdometry::~InertialOdometry() = default;
InertialOdometry::InertialOdometry(InertialOdometry&&) noexcept = default;
InertialOdometry& InertialOdometry::operator=(InertialOdometry&&) noexcept = default;

ImuSampleStatus InertialOdometry::AddSample(const ImuSample& sample) {
  return impl_->AddSample(sample);
}

std::optional<Eigen::Vector3d> InertialOdometry::UpInCamera(Stamp image) const {
  return impl_->UpInCamera(image);
}

std::optional<PoseConstraint> InertialOdometry::Predict(Stamp image) const {
  return impl_->Predict(image);
}

InertialReport InertialOdometry::Update(const Observation& observation) {
  return impl_->Update(observation);
}

void InertialOdometry::MoveMap(const Pose& T_new_old) {
  impl_->MoveMap(T_new_old);
}

void InertialOdometry::Restart() {
  impl_->Restart();
}

std::optional<InertialEstimate> InertialOdometry::estimate() const {
  return impl_->estimate();
}

std::optional<Pose> InertialOdometry::T_WC() const {
  return impl_->T_WC();
}

std::optional<Eigen::Vector3d> InertialOdometry::gravity_W() const {
  return impl_->gravity_W();
}

double InertialOdometry::gravity_sigma() const {
  return impl_->gravity_sigma();
}

double InertialOdometry::time_offset() const {
  return impl_->time_offset();
}

double InertialOdometry::time_offset_sigma() const {
  return impl_->time_offset_sigma();
}

InertialStatus InertialOdometry::status() const {
  return impl_->status();
}

double InertialOdometry::weight() const {
  return impl_->weight();
}

const ImuCalibration& InertialOdometry::calibration() const {
  return impl_->calibration();
}

const Pose& InertialOdometry::T_BC() const {
  return impl_->T_BC();
}

std::optional<ImuPreintegration> InertialOdometry::Between(Stamp from, Stamp to) const {
  return impl_->Between(from, to);
}

std::optional<ImuPreintegration> InertialOdometry::AllBetween(Stamp from, Stamp to) const {
  return impl_->AllBetween(from, to);
}

bool InertialOdometry::IsContradicted(Stamp from, Stamp to) const {
  return impl_->IsContradicted(from, to);
}

}  // namespace highwall
