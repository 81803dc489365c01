#include "engine/study/inertia_left_out.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace lithe {
namespace {

constexpr double kOrthogonal = 1e-9;  // of the mass: what candidates have of a motion as a whole, squared

/// One body of a run.
class LoadedBody {
 public:
  LoadedBody(const DeformableBody& body, const ModelRun& run, const Vector3& gravity)
      : body_(body),
        slice_(*std::ranges::find(run.slices, &body, &Layout::BodySlice::body)),
        gravity_(gravity),
        cache_(body.make_cache()) {
    find_mass(run.states.front());
    find_free_motions(run.states.front());
  }

  /// ρ², kg m²/s⁴
  double unseen(const State& state) {
    VectorX v_dot = state.v_dot.segment(slice_.v, 6 + slice_.linear);
    const BodyState now = evaluate(state);
    const Matrix3& A = now.cache->A;
    const Vector3 omega(now.v[3], now.v[4], now.v[5]), turning = v_dot.segment<3>(3);
    const Vector3 a = A.transpose() * (v_dot.head<3>() - gravity_);
    const Matrix3 G = skew(omega) * skew(omega) + skew(turning), moments = G * second_;
    double whole = mass_ * a.squaredNorm() + 2 * a.dot(G * first_) + (moments * G.transpose()).trace();
    whole -= body_.candidate_forces(now, v_dot.data(), {}, gravity_).squaredNorm();
    if (free_.cols() > 0) {
      Vector6 load;
      load << mass_ * a + G * first_,
          first_.cross(a) +
              Vector3(moments(2, 1) - moments(1, 2), moments(0, 2) - moments(2, 0), moments(1, 0) - moments(0, 1));
      const VectorX along = free_.transpose() * load;
      whole -= along.dot((free_.transpose() * inertia_ * free_).ldlt().solve(along));
    }
    return std::max(whole, 0.0);
  }

 private:
  BodyState evaluate(const State& state) {
    const BodyState now{state.q.data() + slice_.q, state.v.data() + slice_.v, cache_.get()};
    body_.evaluate(now, Level::velocity);
    return now;
  }
  /// Mass, its first and second moments about the frame, body axes.
  void find_mass(State state) {
    state.v.setZero();
    const BodyState now = evaluate(state);
    const int n = 6 + slice_.linear;
    for (int k = 0; k < 6; ++k) {
      VectorX v_dot = VectorX::Zero(n), r = VectorX::Zero(n);
      if (k < 3)
        v_dot.head<3>() = now.cache->A.col(k);
      else
        v_dot[k] = 1;
      body_.add_residual(now, v_dot.data(), Vector3::Zero(), r.data());
      r.head<3>() = now.cache->A.transpose() * r.head<3>();
      inertia_.col(k) = r.head<6>();
    }
    mass_ = inertia_(0, 0);
    first_ = Vector3(inertia_(5, 1), inertia_(3, 2), inertia_(4, 0));
    const Matrix3 J = inertia_.bottomRightCorner<3, 3>();
    second_ = 0.5 * J.trace() * Matrix3::Identity() - J;
  }
  /// Motions as a whole that no candidate has a part of: nothing of the body follows a load along them.
  void find_free_motions(State state) {
    state.v.setZero();
    const BodyState now = evaluate(state);
    MatrixX parts(body_.candidate_stiffness().size(), 6);
    for (int k = 0; k < 6; ++k) {
      VectorX v_dot = VectorX::Zero(6 + slice_.linear);
      if (k < 3)
        v_dot.head<3>() = now.cache->A.col(k);
      else
        v_dot[k] = 1;
      parts.col(k) = body_.candidate_forces(now, v_dot.data(), {}, Vector3::Zero());
    }
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixX> shares(parts.transpose() * parts, inertia_);
    const auto count = (shares.eigenvalues().array() < kOrthogonal).count();
    free_ = shares.eigenvectors().leftCols(count);
  }

  const DeformableBody& body_;
  const Layout::BodySlice slice_;
  const Vector3 gravity_;
  std::unique_ptr<BodyCache> cache_;
  double mass_ = 0;
  Vector3 first_;   // ∫ x dm
  Matrix3 second_;  // ∫ x xᵀ dm
  Matrix6 inertia_;
  MatrixX free_;
};

}  // namespace

std::vector<double> inertia_left_out(const SystemGraph& graph, BodyModels& bodies, const ModelRun& run) {
  bodies.set(run.models);
  std::vector<double> left_out;
  for (const DeformableBody* body : bodies.bodies()) {
    left_out.push_back(0);
    if (body->fidelity().deflection == Deflection::exact || run.states.empty()) continue;
    LoadedBody loaded(*body, run, graph.gravity());
    double most = 0;
    for (const State& state : run.states) most = std::max(most, loaded.unseen(state));
    left_out.back() = std::sqrt(most) / body->candidate_stiffness().maxCoeff();
  }
  return left_out;
}

}  // namespace lithe
