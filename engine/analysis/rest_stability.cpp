#include "engine/analysis/rest_stability.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace lithe {
namespace {

constexpr double kLeastShift = 1e-4, kMostShift = 1e8;  // 1/s²
constexpr double kShiftFactor = 30;                     // between shifts that are tried
constexpr int kMostVectors = 40;                        // of the space
constexpr int kKept = 4;                                // Ritz vectors, where the space is full
constexpr int kStarts = 3;                              // random vectors a shift
constexpr int kMostSteps = 60;                          // of Davidson, a shift
constexpr double kConverged = 1e-9;                     // of ω²
constexpr double kDependent = 1e-7;                     // what is left of a vector beside the others
constexpr double kRefined = 1e-6;                       // of ω² < 0, by a nearer shift
constexpr int kMostRefinements = 6;
constexpr double kBesideOthers = 1e-13;  // of the largest ω² of the space: what round-off mixes in of its shape
constexpr double kTold = 1e-7;           // 1/s²: slower motions are not told from none
constexpr double kFollows = 1e-4;        // of K - Kᵀ between two shapes, beside their stiffnesses

class LowestStiffness {
 public:
  LowestStiffness(StaticEquations& balance, const State& state, double length)
      : balance_(balance), state_(state), length_(length), freedoms_(balance.freedoms()) {}

  void judge(Equilibrium& found) {
    found.stability = RestStability::unknown;
    if (freedoms_ == 0) {
      found.stability = RestStability::stable;
      found.lowest_stiffness = std::numeric_limits<double>::infinity();
      return;
    }
    if (!search(kLeastShift)) return;
    refine();
    measure();
    bool sure = complete_;
    if (!sure && lowest_ > uncertain_) {
      sure = balance_.factorize(kLeastShift, state_.lambda) && balance_.surely_convex();
      for (double shift = kShiftFactor * kLeastShift; !sure && lowest_ > uncertain_ && shift < kMostShift;
           shift *= kShiftFactor) {
        if (!search(shift)) return;
        refine();
        measure();
      }
    }
    found.lowest_stiffness = lowest_;
    found.stiffness_uncertainty = uncertain_;
    found.softest = shape_;
    const double lowest = lowest_;
    if (loads_follow()) return;
    if (lowest < -uncertain_)
      found.stability = RestStability::unstable;
    else if (lowest > uncertain_ && sure)
      found.stability = RestStability::stable;
  }

 private:
  /// Adds a vector, made orthonormal to the others by M. False: it depends on them.
  bool add(VectorX v) {
    VectorX of_mass = balance_.mass_times(v, state_.lambda);
    double before = std::sqrt(std::max(v.dot(of_mass), 0.0));
    if (!(before > 0) || !std::isfinite(before)) return false;
    v /= before;
    double left = 1;
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t i = 0; i < space_.size(); ++i) v -= of_mass_[i].dot(v) * space_[i];
      of_mass = balance_.mass_times(v, state_.lambda);
      const double norm = std::sqrt(std::max(v.dot(of_mass), 0.0));
      left *= norm;
      if (!(left > kDependent)) return false;
      v /= norm;
      of_mass /= norm;
    }
    of_stiffness_.push_back(balance_.stiffness_times(v, state_.lambda, length_));
    space_.push_back(std::move(v));
    of_mass_.push_back(std::move(of_mass));
    const auto n = static_cast<Eigen::Index>(space_.size());
    projected_.conservativeResize(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto at = static_cast<std::size_t>(i);
      projected_(i, n - 1) = space_[at].dot(of_stiffness_.back());
      projected_(n - 1, i) = space_.back().dot(of_stiffness_[at]);
    }
    return of_stiffness_.back().allFinite();
  }

  static VectorX sum(const std::vector<VectorX>& of, const VectorX& weights) {
    VectorX x = VectorX::Zero(of.front().size());
    for (std::size_t i = 0; i < of.size(); ++i) x += weights[static_cast<Eigen::Index>(i)] * of[i];
    return x;
  }

  void find_ritz_pairs() {
    const Eigen::SelfAdjointEigenSolver<MatrixX> solver(0.5 * (projected_ + projected_.transpose()));
    ritz_ = solver.eigenvectors();
    values_ = solver.eigenvalues();
    lowest_ = values_[0];
    shape_ = sum(space_, ritz_.col(0));
  }

  /// The space of the lowest Ritz vectors alone.
  void shorten() {
    find_ritz_pairs();
    std::vector<VectorX> kept;
    for (int i = 0; i < kKept; ++i) kept.push_back(sum(space_, ritz_.col(i)));
    space_.clear(), of_mass_.clear(), of_stiffness_.clear();
    projected_.resize(0, 0);
    for (VectorX& v : kept) add(std::move(v));
  }

  bool is_complete() const { return static_cast<int>(space_.size()) >= freedoms_; }

  /// False: the factor is singular, or values are not finite.
  bool search(double shift) {
    complete_ = is_complete();
    if (complete_) return true;
    if (!balance_.factorize(shift, state_.lambda)) return false;
    const Eigen::Index n = balance_.force.size();
    VectorX v(n), none = balance_.gap;
    for (int i = 0; i < kStarts && !is_complete(); ++i) {
      for (double& x : v) x = static_cast<double>(random_()) / 2147483648.0 - 1;
      for (int power = 0; power < 2; ++power) {
        v = balance_.mass_times(v, state_.lambda);
        none.setZero();
        if (!balance_.solve(v, none)) return false;
        v /= v.lpNorm<Eigen::Infinity>();
      }
      add(v);
    }
    if (space_.empty()) return false;
    for (int k = 0; k < kMostSteps; ++k) {
      find_ritz_pairs();
      complete_ = is_complete();
      if (complete_) return true;
      VectorX residual = sum(of_stiffness_, ritz_.col(0)) - lowest_ * sum(of_mass_, ritz_.col(0));
      VectorX correction = residual;
      none.setZero();
      if (!balance_.solve(correction, none)) return false;
      if (std::abs(correction.dot(residual)) <= kConverged * std::abs(lowest_)) return true;
      if (static_cast<int>(space_.size()) >= kMostVectors) shorten();
      if (!add(correction)) return true;
    }
    return true;
  }

  /// A negative ω² is found the better the nearer the shift is.
  void refine() {
    for (int i = 0; i < kMostRefinements && lowest_ < 0 && !complete_; ++i) {
      const double before = lowest_;
      if (!search(2 * -lowest_) || lowest_ > (1 + kRefined) * before) break;
    }
  }

  /// ω² of the shape anew, and what differences and round-off leave of it.
  void measure() {
    double coarse = 0;
    const double square = shape_.dot(balance_.mass_times(shape_, state_.lambda));
    lowest_ = shape_.dot(balance_.stiffness_times(shape_, state_.lambda, length_, &coarse)) / square;
    uncertain_ = 0.1 * std::abs(coarse / square - lowest_) + noise(shape_) / square +
                 kBesideOthers * values_.lpNorm<Eigen::Infinity>() + kTold;
  }
  /// Of dᵀ K d: the balance's last bits over the way that it was differenced along.
  double noise(const VectorX& d) const {
    return d.cwiseAbs().dot(balance_.round_off()) * d.lpNorm<Eigen::Infinity>() / length_;
  }

  /// Whether K is not symmetric: no potential has these forces, and what K says is not all.
  bool loads_follow() {
    find_ritz_pairs();
    const auto count = static_cast<int>(std::min<Eigen::Index>(values_.size(), kKept));
    const MatrixX low = ritz_.leftCols(count).transpose() * projected_ * ritz_.leftCols(count);
    for (int i = 0; i < count; ++i)
      for (int j = 0; j < i; ++j) {
        const double round_off = noise(sum(space_, ritz_.col(i))) + noise(sum(space_, ritz_.col(j)));
        if (std::abs(low(i, j) - low(j, i)) > kFollows * std::sqrt(std::abs(values_[i] * values_[j])) + 10 * round_off)
          return true;
      }
    return false;
  }

  StaticEquations& balance_;
  const State& state_;
  const double length_;
  const int freedoms_;
  std::mt19937 random_{1};
  std::vector<VectorX> space_, of_mass_, of_stiffness_;
  MatrixX projected_, ritz_;
  VectorX values_, shape_;
  double lowest_ = 0, uncertain_ = 0;
  bool complete_ = false;
};

}  // namespace

void judge_rest(StaticEquations& balance, double length, Equilibrium& found) {
  const State& state = found.state;
  balance.evaluate(state.time, state.q, state.lambda);
  LowestStiffness(balance, state, length).judge(found);
}

}  // namespace lithe
