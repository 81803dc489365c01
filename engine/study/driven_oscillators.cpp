#include "engine/study/driven_oscillators.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "engine/run/driven_oscillator.h"

namespace lithe {
namespace {

constexpr double kHeld = 1e-9;  // of the largest eigenvalue of A, mass-orthonormal coordinates: round-off below

/// Of what is not negative but for round-off.
VectorX root(const VectorX& x) {
  return x.unaryExpr([](double value) { return std::sqrt(std::max(value, 0.0)); });
}

}  // namespace

DrivenOscillators::DrivenOscillators(const MatrixX& A, const VectorX& damping, const VectorX& stiffness)
    : A_(A), root_(root(stiffness)) {
  const MatrixX mobility = 0.5 * (A + A.transpose()), scaled = root_.asDiagonal() * mobility * root_.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixX> eigen(scaled);
  V_ = eigen.eigenvectors();
  frequencies_ = root(eigen.eigenvalues());
  // Directions that joints hold: as many as A has no mobility in.
  const VectorX mobilities = Eigen::SelfAdjointEigenSolver<MatrixX>(mobility, Eigen::EigenvaluesOnly).eigenvalues();
  const auto held = mobilities.size() > 0 ? (mobilities.array() < kHeld * mobilities.maxCoeff()).count() : 0;
  frequencies_.head(held).setZero();
  // Of damping in proportion to stiffness or mass this is all; other couplings through it are left out.
  const MatrixX forces = V_.transpose() * root_.asDiagonal() * A,
                rates = damping.cwiseQuotient(root_).asDiagonal() * V_;
  damping_ = (forces * rates).diagonal().cwiseMax(0);
}

MatrixX DrivenOscillators::inertia() const {
  const VectorX inverse = (frequencies_.array() > 0).select(frequencies_.array().square().inverse(), 0.0);
  const MatrixX forces = root_.asDiagonal() * V_;
  return forces * inverse.asDiagonal() * forces.transpose();
}

DrivenOscillators::Response DrivenOscillators::respond(const MatrixX& accelerations, double interval,
                                                       const VectorX& start, const VectorX& start_rate) const {
  const Eigen::Index n = accelerations.rows(), samples = accelerations.cols();
  const MatrixX g = V_.transpose() * root_.asDiagonal() * accelerations;
  MatrixX z(n, samples), rate(n, samples), acceleration(n, samples);
  const VectorX z0 = V_.transpose() * root_.asDiagonal() * start,
                rate0 = V_.transpose() * root_.asDiagonal() * start_rate;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double w = frequencies_[i], d = damping_[i];
    if (w == 0) {
      z.row(i).setZero(), rate.row(i).setZero(), acceleration.row(i).setZero();
      continue;
    }
    OscillatorState swing{z0[i], rate0[i]};
    for (Eigen::Index k = 0; k < samples; ++k) {
      if (k > 0) swing = driven(swing, w * w, d, g(i, k - 1), g(i, k), interval);
      z(i, k) = swing.z, rate(i, k) = swing.rate, acceleration(i, k) = g(i, k) - d * swing.rate - w * w * swing.z;
    }
  }
  const MatrixX back = root_.cwiseInverse().asDiagonal() * V_;
  return {back * z, back * rate, back * acceleration};
}

}  // namespace lithe
