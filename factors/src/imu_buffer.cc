#include <highwall/factors/imu_buffer.h>

#include <algorithm>
#include <cmath>

#include <highwall/core/error.h>
#include <highwall/internal/imu_buffer_options.h>

namespace highwall {
namespace {

bool Earlier(const ImuSample& sample, Stamp stamp) {
  return sample.stamp < stamp;
}

// Eq. 1
ImuSample Interpolate(const ImuSample& a, const ImuSample& b, Stamp stamp) {
  const double s = ToSeconds(stamp - a.stamp) / ToSeconds(b.stamp - a.stamp);
  return {stamp, (1.0 - s) * a.gyroscope + s * b.gyroscope,
          (1.0 - s) * a.accelerometer + s * b.accelerometer};
}

}  // namespace

bool IsFinite(const ImuSample& sample) {
  return sample.gyroscope.allFinite() && sample.accelerometer.allFinite();
}

bool IsPossible(const ImuSample& sample) {
  return IsFinite(sample) && sample.stamp <= kMaxStamp && sample.stamp >= -kMaxStamp &&
         sample.gyroscope.cwiseAbs().maxCoeff() <= kMaxAngularRate &&
         sample.accelerometer.cwiseAbs().maxCoeff() <= kMaxSpecificForce;
}

void ImuBufferOptions::Validate() const {
  RequireInRange(*this, "ImuBufferOptions");
}

const char* ToString(ImuSampleStatus status) {
  switch (status) {
    case ImuSampleStatus::kAdded:
      return "added";
    case ImuSampleStatus::kReordered:
      return "reordered";
    case ImuSampleStatus::kDuplicate:
      return "duplicate";
    case ImuSampleStatus::kTooOld:
      return "too old";
    case ImuSampleStatus::kNotFinite:
      return "not finite";
    case ImuSampleStatus::kImpossible:
      return "impossible";
    case ImuSampleStatus::kJumped:
      return "jumped";
  }
  return "unknown";
}

const char* Advice(ImuSampleStatus status) {
  switch (status) {
    case ImuSampleStatus::kAdded:
    case ImuSampleStatus::kReordered:
      return "";
    case ImuSampleStatus::kDuplicate:
      return "a reading with this stamp exists already: pass each once";
    case ImuSampleStatus::kTooOld:
      return "the reading is older than the buffer: pass readings as they arrive";
    case ImuSampleStatus::kNotFinite:
      return "the reading is NaN or infinite: skip it";
    case ImuSampleStatus::kImpossible:
      return "the value or the stamp is impossible for a sensor: check the units (rad/s, m/s^2, "
             "ns)";
    case ImuSampleStatus::kJumped:
      return "the stamp is too far from those before: check the sensor's clock and the unit (ns); "
             "continue with the next reading, a permanent shift of the clock is followed";
  }
  return "";
}

ImuBuffer::ImuBuffer(const ImuBufferOptions& options) : options_(options) {
  options_.Validate();
}

bool ImuBuffer::Jumps(Stamp stamp) {
  const double ahead = samples_.empty() ? 0.0 : ToSeconds(stamp - newest());
  const double longest_back = std::max(options_.horizon, kMaxStampJump);
  if (ahead <= kMaxStampJump && ahead >= -longest_back) {
    jumped_.reset();
    return false;
  }
  if (jumped_ == stamp) return true;  // the same reading was given twice
  const bool follows = jumped_ && std::abs(ToSeconds(stamp - *jumped_)) <= options_.max_step;
  jumps_ = follows ? jumps_ + 1 : 1;
  jumped_ = follows ? std::max(*jumped_, stamp) : stamp;
  if (jumps_ <= kReadingsAfterJump) return true;
  jumped_.reset();
  if (ahead < 0.0) {
    samples_.clear();
    forgotten_.reset();
  }
  return false;
}

ImuSampleStatus ImuBuffer::Add(const ImuSample& sample) {
  if (!IsFinite(sample)) return ImuSampleStatus::kNotFinite;
  if (!IsPossible(sample)) return ImuSampleStatus::kImpossible;
  if (Jumps(sample.stamp)) return ImuSampleStatus::kJumped;
  if (forgotten_ && sample.stamp <= *forgotten_) return ImuSampleStatus::kTooOld;
  const auto place = std::lower_bound(samples_.begin(), samples_.end(), sample.stamp, Earlier);
  if (place != samples_.end() && place->stamp == sample.stamp) return ImuSampleStatus::kDuplicate;
  const bool newest = place == samples_.end();
  samples_.insert(place, sample);
  if (!newest) return ImuSampleStatus::kReordered;

  const Stamp limit = sample.stamp - FromSeconds(options_.horizon);
  while (samples_.front().stamp < limit) {
    forgotten_ = samples_.front().stamp;
    samples_.pop_front();
  }
  return ImuSampleStatus::kAdded;
}

std::optional<ImuInterval> ImuBuffer::Between(Stamp start, Stamp end) const {
  HIGHWALL_REQUIRE(start < end, "ImuBuffer::Between: start " + FormatStamp(start) +
                                    " s is not before end " + FormatStamp(end) + " s");
  if (samples_.empty() || samples_.front().stamp > start || samples_.back().stamp < end) {
    return std::nullopt;
  }
  // Readings at or around both ends: first <= start, last >= end.
  auto first = std::lower_bound(samples_.begin(), samples_.end(), start, Earlier);
  if (first->stamp > start) --first;
  const auto last = std::lower_bound(first, samples_.end(), end, Earlier);

  ImuInterval interval;
  interval.samples.reserve(static_cast<std::size_t>(last - first) + 1);
  interval.samples.push_back(first->stamp == start ? *first
                                                   : Interpolate(*first, *(first + 1), start));
  for (auto it = first + 1; it <= last; ++it) {
    const double step = ToSeconds(it->stamp - (it - 1)->stamp);
    interval.largest_step = std::max(interval.largest_step, step);
    if (step > options_.max_step) ++interval.gaps;
    if (it->stamp < end) interval.samples.push_back(*it);
  }
  interval.samples.push_back(last->stamp == end ? *last : Interpolate(*(last - 1), *last, end));
  return interval;
}

Stamp ImuBuffer::oldest() const {
  HIGHWALL_REQUIRE(!samples_.empty(), "ImuBuffer::oldest: the buffer is empty");
  return samples_.front().stamp;
}

Stamp ImuBuffer::newest() const {
  HIGHWALL_REQUIRE(!samples_.empty(), "ImuBuffer::newest: the buffer is empty");
  return samples_.back().stamp;
}

}  // namespace highwall
