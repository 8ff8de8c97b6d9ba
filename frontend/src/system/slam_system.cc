#include <highwall/frontend/system/slam_system.h>

#include <utility>

#include "system/slam_system_impl.h"

namespace highwall {

SlamSystem::SlamSystem(const RgbdSensor& sensor, const SlamOptions& options, SlamInputs inputs)
    : impl_(std::make_unique<Impl>(sensor, options, std::move(inputs))) {}

SlamSystem::~SlamSystem() = default;
SlamSystem::SlamSystem(SlamSystem&&) noexcept = default;
SlamSystem& SlamSystem::operator=(SlamSystem&&) noexcept = default;

void SlamSystem::SetCallbacks(SlamCallbacks callbacks) {
  impl_->SetCallbacks(std::move(callbacks));
}

ImuSampleStatus SlamSystem::AddImu(const ImuSample& sample) {
  return impl_->AddImu(sample);
}

ReferenceFrameId SlamSystem::AddReferenceFrame(const ReferenceFrame& frame) {
  return impl_->AddReferenceFrame(frame);
}

void SlamSystem::AddFactor(PoseFactor factor) {
  impl_->AddFactor(std::move(factor));
}

std::optional<Pose> SlamSystem::T_FW(ReferenceFrameId frame) const {
  return impl_->T_FW(frame);
}

FactorCounts SlamSystem::factor_counts() const {
  return impl_->factor_counts();
}

std::map<std::string, FactorCounts> SlamSystem::factor_counts_by_source() const {
  return impl_->factor_counts_by_source();
}

FrameResult SlamSystem::Track(const RgbdImage& image) {
  return impl_->Track(image);
}

cv::Mat SlamSystem::DynamicMaskOf(KeyFrameId keyframe) const {
  return impl_->DynamicMaskOf(keyframe);
}

cv::Mat SlamSystem::CorrectedDepth(KeyFrameId keyframe, const cv::Mat& depth) const {
  return impl_->CorrectedDepth(keyframe, depth);
}

std::vector<LoopReport> SlamSystem::Finish() {
  return impl_->Finish();
}

std::optional<KeyframeView> SlamSystem::keyframe_view(KeyFrameId keyframe,
                                                      const RgbdImage& image) const {
  return impl_->keyframe_view(keyframe, image);
}

void SlamSystem::SetBacklog(std::size_t images) {
  impl_->SetBacklog(images);
}

PostponedWork SlamSystem::postponed() const {
  return impl_->postponed();
}

KeyframeEvent SlamSystem::waiting_keyframes() const {
  return impl_->waiting_keyframes();
}

BundleAdjustmentReport SlamSystem::AdjustAll() {
  return impl_->AdjustAll();
}

Trajectory SlamSystem::trajectory() const {
  return impl_->trajectory();
}

std::vector<FrameVelocity> SlamSystem::velocities() const {
  return impl_->velocities();
}

std::vector<SubmapTrajectory> SlamSystem::submaps() const {
  return impl_->submaps();
}

Trajectory SlamSystem::keyframe_trajectory() const {
  return impl_->keyframe_trajectory();
}

const Map& SlamSystem::map() const {
  return impl_->map();
}

SensorEstimate SlamSystem::sensor() const {
  return impl_->sensor();
}

SensorVerdict SlamSystem::verdict() const {
  return impl_->verdict();
}

int SlamSystem::refined_frames() const {
  return impl_->refined_frames();
}

std::vector<MemoryShare> SlamSystem::memory() const {
  return impl_->memory();
}

}  // namespace highwall
