#include "inertial/window_landmarks.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <highwall/core/manifolds.h>
#include <highwall/core/so3.h>

namespace highwall {
namespace {

using internal::LandmarkNormal;

// Maximum number of separate steps of a landmark at one x, and the decrease that justifies a step,
// as a fraction of the mean cost of a landmark.
constexpr int kMaxLandmarkSteps = 10;
constexpr double kWorthALandmarkStep = 1e-3;

void MoveLandmark(const WindowPoint&, const double* value, const double* delta, double* out) {
  for (int i = 0; i < 3; ++i) out[i] = value[i] + delta[i];
}

void MoveLandmark(const WindowLine&, const double* value, const double* delta, double* out) {
  LineManifold().Plus(value, delta, out);
}

// Number of frames that observe the landmark.
template <class Landmark>
std::size_t FramesOf(const Landmark& landmark) {
  std::size_t count = 0;
  int last = -1;
  for (const auto& view : landmark.views) {
    count += view.frame != last;
    last = view.frame;
  }
  return count;
}

// Returns the coupling with the frame of the next view.
template <class Couplings>
auto& CouplingWith(int frame, Couplings* couplings) {
  if (couplings->count == 0 || couplings->frames[couplings->count - 1] != frame) {
    couplings->frames[couplings->count] = frame;
    couplings->E[couplings->count].setZero();
    ++couplings->count;
  }
  return couplings->E[couplings->count - 1];
}

template <class Vector>
void GrowTo(std::size_t size, Vector* vector) {
  if (vector->size() < size) vector->resize(size);
}

}  // namespace

WindowLoss::Value WindowLoss::At(double s) const {
  if (s <= width * width) return {scale * s, scale};
  const double norm = std::sqrt(s);
  return {scale * (2.0 * width * norm - width * width), scale * width / norm};
}

void WindowLandmarks::Begin() {
  places_.clear();
  Place next;
  const auto lay_out = [&]<class Landmark>(const std::vector<Landmark>& landmarks) {
    Couplings<Landmark::kDim>& couplings = CouplingsOf<Landmark>();
    for (const Landmark& landmark : landmarks) {
      const std::size_t frames = FramesOf(landmark);
      places_.push_back(next);
      next.value += Landmark::kSize;
      next.feedback += Landmark::kDim * (1 + 6 * frames);
      GrowTo(frames, &couplings.E);
      GrowTo(frames, &couplings.frames);
      if constexpr (Landmark::kDim == 3) {
        GrowTo(landmark.views.size(), &point_terms_);
      } else {
        GrowTo(landmark.views.size(), &line_terms_);
      }
    }
  };
  lay_out(points_);
  lay_out(lines_);
  places_.push_back(next);  // the end
}

bool WindowLandmarks::Evaluate(const WindowFrames& frames, const Step* step, Estimates* estimates,
                               FrameSystem* system) {
  frames_ = &frames;
  begins_ = step == nullptr;
  estimates->values.resize(places_.back().value);
  estimates->feedback.resize(places_.back().feedback);
  estimates->costs.resize(places_.size() - 1);
  estimates->cost = 0.0;
  worth_ = begins_ ? 0.0
                   : kWorthALandmarkStep * step->from.cost /
                         static_cast<double>(std::max<std::size_t>(places_.size() - 1, 1));
  index_ = 0;
  return EvaluateAll(points_, step, estimates, system) &&
         EvaluateAll(lines_, step, estimates, system);
}

template <class Landmark>
bool WindowLandmarks::EvaluateAll(std::vector<Landmark>& landmarks, const Step* step,
                                  Estimates* estimates, FrameSystem* system) {
  for (Landmark& landmark : landmarks) {
    const Place place = places_[index_];
    LandmarkNormal<Landmark::kDim> normal(Landmark::kDim);
    double* const value = &estimates->values[place.value];
    if (!Fit(landmark, step, value, &normal)) return false;
    estimates->costs[index_] = normal.cost;
    estimates->cost += normal.cost;
    Accumulate(landmark, system);
    Eliminate<Landmark>(normal, &estimates->feedback[place.feedback], system);
    ++index_;
  }
  return true;
}

// Predicts the landmark from the step of the frames and refines it by steps of its own. Leaves its
// views linearized at the final value.
template <class Landmark>
bool WindowLandmarks::Fit(Landmark& landmark, const Step* step, double* value,
                          LandmarkNormal<Landmark::kDim>* normal) {
  if (step == nullptr) {
    const double* const present = landmark.value.data();
    std::copy_n(present, Landmark::kSize, value);
    return Linearize(landmark, value, normal);
  }
  Follow(landmark, *step, value);
  const bool followed = Linearize(landmark, value, normal);
  // After a failed first trial the old landmark may be better: with shorter and shorter steps of
  // the frames the cost then converges to its previous value.
  if (!followed || (step->retry && normal->cost > step->from.costs[index_])) {
    const double cost = followed ? normal->cost : std::numeric_limits<double>::infinity();
    const double* const before = &step->from.values[places_[index_].value];
    const bool stayed = Linearize(landmark, before, normal);
    if (!stayed && !followed) return false;
    if (stayed && normal->cost <= cost) {
      std::copy_n(before, Landmark::kSize, value);
    } else if (!Linearize(landmark, value, normal)) {
      return false;
    }
  }
  return Descend(landmark, value, normal);
}

// Gauss-Newton steps of the landmark alone, shortened if they increase the cost.
template <class Landmark>
bool WindowLandmarks::Descend(Landmark& landmark, double* value,
                              LandmarkNormal<Landmark::kDim>* normal) {
  double tried[Landmark::kSize];
  double length = 1.0;
  for (int step = 0; step < kMaxLandmarkSteps && normal->Gain() > worth_; ++step) {
    const double cost = normal->cost;
    const Eigen::Matrix<double, Landmark::kDim, 1> delta = -length * normal->u;
    MoveLandmark(landmark, value, delta.data(), tried);
    if (Linearize(landmark, tried, normal) && normal->cost < cost) {
      std::copy_n(tried, Landmark::kSize, value);
      length = 1.0;
      continue;
    }
    if (!Linearize(landmark, value, normal)) return false;
    length *= 0.25;
  }
  if (length < 1.0) normal->u *= length;  // the landmark must not take the full step later either
  return true;
}

template <class Landmark>
void WindowLandmarks::Follow(const Landmark& landmark, const Step& step, double* value) const {
  constexpr int kDim = Landmark::kDim;
  const double* feedback = &step.from.feedback[places_[index_].feedback];
  Eigen::Matrix<double, kDim, 1> delta =
      -Eigen::Map<const Eigen::Matrix<double, kDim, 1>>(feedback);
  feedback += kDim;
  int last = -1;
  for (const auto& view : landmark.views) {
    if (view.frame == last) continue;
    last = view.frame;
    const Eigen::Map<const Eigen::Matrix<double, kDim, 6>> W(feedback);
    delta.noalias() -= W.lazyProduct(step.frames.template segment<6>(6 * view.frame));
    feedback += 6 * kDim;
  }
  MoveLandmark(landmark, &step.from.values[places_[index_].value], delta.data(), value);
}

bool WindowLandmarks::Linearize(WindowPoint& point, const double* value,
                                LandmarkNormal<3>* normal) {
  normal->H.setZero();
  normal->g.setZero();
  normal->cost = 0.0;
  const Eigen::Map<const Eigen::Vector3d> p_V(value);
  for (std::size_t k = 0; k < point.views.size(); ++k) {
    WindowPointView& view = point.views[k];
    const WindowFrame& frame = frames_->frames[static_cast<std::size_t>(view.frame)];
    PointTerm& term = point_terms_[k];
    term.p_F.noalias() = frame.R_FV * (p_V - frame.p_VF);
    Eigen::Vector3d r;
    Eigen::Matrix3d J;
    term.active = true;
    if (IsCamera(view.frame)) {
      term.active = projection_.EvaluateInCamera<3>(term.p_F, view.rows, &r, &J);
    } else {
      J = view.rows.A;
      r = J * term.p_F + view.rows.b;
    }
    if (begins_) view.inside = term.active;
    if (!term.active) {
      if (view.inside) return false;
      continue;
    }
    const WindowLoss::Value loss = view.loss.At(r.squaredNorm());
    const Eigen::Matrix3d JtW = loss.weight * J.transpose();
    term.N.noalias() = JtW * J;
    term.n.noalias() = JtW * r;
    normal->cost += loss.rho;
    normal->H.noalias() += frame.R_FV.transpose() * (term.N * frame.R_FV).eval();
    normal->g.noalias() += frame.R_FV.transpose() * term.n;
  }
  if (!std::isfinite(normal->cost + normal->H.trace())) return false;
  normal->Solve();
  return true;
}

bool WindowLandmarks::Linearize(WindowLine& line, const double* value, LandmarkNormal<4>* normal) {
  normal->H.setZero();
  normal->g.setZero();
  normal->cost = 0.0;
  Eigen::Matrix<double, 6, 4, Eigen::RowMajor> plus;
  LineManifold().PlusJacobian(value, plus.data());
  for (std::size_t k = 0; k < line.views.size(); ++k) {
    WindowLineView& view = line.views[k];
    const WindowFrame& frame = frames_->frames[static_cast<std::size_t>(view.frame)];
    LineTerm& term = line_terms_[k];
    Eigen::Matrix<double, 4, 7, Eigen::RowMajor> J_frame;
    Eigen::Matrix<double, 4, 6, Eigen::RowMajor> J_line;
    J_frame.setZero(), J_line.setZero(), term.r.setZero();  // the rows that the factor lacks
    const double* parameters[] = {frame.T_VF.data(), value};
    double* jacobians[] = {J_frame.data(), J_line.data()};
    if (!view.factor->Evaluate(parameters, term.r.data(), jacobians)) return false;
    const bool active = (term.r.array() != 0.0).any() || (J_line.array() != 0.0).any();
    if (begins_) view.inside = active;
    term.weight = 0.0;
    if (!active) {
      if (view.inside) return false;
      continue;
    }
    const WindowLoss::Value loss = view.loss.At(term.r.squaredNorm());
    term.weight = loss.weight;
    term.of_frame.noalias() = J_frame.lazyProduct(frame.plus);
    term.of_line.noalias() = J_line.lazyProduct(plus);
    normal->cost += loss.rho;
    const Eigen::Matrix4d JtW = loss.weight * term.of_line.transpose();
    normal->H.noalias() += JtW * term.of_line;
    normal->g.noalias() += JtW * term.r;
  }
  if (!std::isfinite(normal->cost + normal->H.trace())) return false;
  normal->Solve();
  return true;
}

// p_F = R_FV (p_V - p_VF): a step of the frame moves it by M = [-R_FV, Hat(p_F)].
void WindowLandmarks::Accumulate(const WindowPoint& point, FrameSystem* system) {
  point_couplings_.count = 0;
  for (std::size_t k = 0; k < point.views.size(); ++k) {
    const int frame = point.views[k].frame;
    auto& E = CouplingWith(frame, &point_couplings_);
    const PointTerm& term = point_terms_[k];
    if (!term.active) continue;
    const Eigen::Matrix3d& R_FV = frames_->frames[static_cast<std::size_t>(frame)].R_FV;
    Eigen::Matrix<double, 3, 6> M;
    M.leftCols<3>() = -R_FV;
    M.rightCols<3>() = so3::Hat(term.p_F);
    const Eigen::Matrix<double, 3, 6> NM = term.N.lazyProduct(M);
    E.noalias() += R_FV.transpose().lazyProduct(NM);
    system->H(frame, frame).noalias() += M.transpose().lazyProduct(NM);
    system->g(frame).noalias() += M.transpose().lazyProduct(term.n);
  }
}

void WindowLandmarks::Accumulate(const WindowLine& line, FrameSystem* system) {
  line_couplings_.count = 0;
  for (std::size_t k = 0; k < line.views.size(); ++k) {
    const int frame = line.views[k].frame;
    auto& E = CouplingWith(frame, &line_couplings_);
    const LineTerm& term = line_terms_[k];
    if (term.weight == 0.0) continue;
    const Eigen::Matrix<double, 4, 6> WJ = term.weight * term.of_frame;
    E.noalias() += term.of_line.transpose().lazyProduct(WJ);
    system->H(frame, frame).noalias() += term.of_frame.transpose().lazyProduct(WJ);
    system->g(frame).noalias() += WJ.transpose().lazyProduct(term.r);
  }
}

// Subtracts H_xl H_ll^-1 H_lx and H_xl H_ll^-1 g_l.
template <class Landmark>
void WindowLandmarks::Eliminate(const LandmarkNormal<Landmark::kDim>& normal, double* feedback,
                                FrameSystem* system) {
  constexpr int kDim = Landmark::kDim;
  const Couplings<kDim>& couplings = CouplingsOf<Landmark>();
  Eigen::Map<Eigen::Matrix<double, kDim, 1>> u(feedback);
  u = normal.u;
  feedback += kDim;
  for (std::size_t a = 0; a < couplings.count; ++a) {
    const int frame = couplings.frames[a];
    Eigen::Matrix<double, kDim, 6> W;
    W.noalias() = normal.inverse.lazyProduct(couplings.E[a]);
    Eigen::Map<Eigen::Matrix<double, kDim, 6>>(feedback + a * 6 * kDim) = W;
    const Eigen::Matrix<double, 6, kDim> gain = W.transpose();
    system->g(frame).noalias() -= gain.lazyProduct(normal.g);
    system->eliminated(frame) += W.cwiseProduct(couplings.E[a]).colwise().sum().transpose();
    for (std::size_t b = a; b < couplings.count; ++b) {
      system->H(frame, couplings.frames[b]).noalias() -= gain.lazyProduct(couplings.E[b]);
    }
  }
}

void WindowLandmarks::SetValues(const Estimates& estimates) {
  std::size_t index = 0;
  const auto set = [&](auto& landmarks) {
    for (auto& landmark : landmarks) {
      const double* const value = &estimates.values[places_[index++].value];
      std::copy_n(value, std::remove_reference_t<decltype(landmark)>::kSize, landmark.value.data());
    }
  };
  set(points_);
  set(lines_);
}

bool WindowLandmarks::Leave(const WindowFrames& frames, FrameSystem* system) {
  frames_ = &frames;
  begins_ = true;
  return LeaveAll(&points_, system) && LeaveAll(&lines_, system);
}

template <class Landmark>
bool WindowLandmarks::LeaveAll(std::vector<Landmark>* landmarks, FrameSystem* system) {
  std::vector<double> feedback;
  const auto leaves = [](const Landmark& landmark) {
    return landmark.views.front().frame <= MapFrame(0);
  };
  for (Landmark& landmark : *landmarks) {
    if (!leaves(landmark)) continue;
    LandmarkNormal<Landmark::kDim> normal(Landmark::kDim);
    const double* const value = landmark.value.data();
    if (!Linearize(landmark, value, &normal)) return false;
    feedback.resize(Landmark::kDim * (1 + 6 * landmark.views.size()));
    Accumulate(landmark, system);
    Eliminate<Landmark>(normal, feedback.data(), system);
  }
  std::erase_if(*landmarks, leaves);
  for (Landmark& landmark : *landmarks) {
    for (auto& view : landmark.views) view.frame -= CameraFrame(1);
  }
  return true;
}

}  // namespace highwall
