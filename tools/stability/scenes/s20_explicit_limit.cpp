// S20: explicit Runge-Kutta on a cantilever of beam elements: the finest mode that nobody looks at sets the step.
#include <Eigen/Eigenvalues>

#include "bodies/flexible/flexible_body.h"
#include "joints/fixed_joint.h"
#include "tools/stability/bench.h"
#include "tools/stability/methods/explicit_index1.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

constexpr double kLength = 1, kSide = 0.01, kYoung = 2.1e11, kDensity = 7850;  // steel, 10 x 10 mm

/// Frequencies (rad/s) of a cantilever of cubic (Hermite) elements, bending in a plane.
VectorX frequencies_of(int elements) {
  const double h = kLength / elements, stiffness = kYoung * std::pow(kSide, 4) / 12 / (h * h * h),
               mass = kDensity * kSide * kSide * h / 420;
  Eigen::Matrix4d k, m;
  k << 12, 6 * h, -12, 6 * h, 6 * h, 4 * h * h, -6 * h, 2 * h * h, -12, -6 * h, 12, -6 * h, 6 * h, 2 * h * h, -6 * h,
      4 * h * h;
  m << 156, 22 * h, 54, -13 * h, 22 * h, 4 * h * h, 13 * h, -3 * h * h, 54, 13 * h, 156, -22 * h, -13 * h, -3 * h * h,
      -22 * h, 4 * h * h;
  MatrixX K = MatrixX::Zero(2 * elements + 2, 2 * elements + 2), M = K;
  for (int e = 0; e < elements; ++e) {
    K.block<4, 4>(2 * e, 2 * e) += stiffness * k;
    M.block<4, 4>(2 * e, 2 * e) += mass * m;
  }
  const int n = 2 * elements;
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixX> modes(K.bottomRightCorner(n, n), M.bottomRightCorner(n, n),
                                                                Eigen::EigenvaluesOnly);
  return modes.eigenvalues().cwiseSqrt();
}

/// The cantilever in its modes, all at the same speed; its frame is welded to the ground, so that what couples modes
/// and frame acts on the weld alone and is left out.
class Cantilever : public Bench {
 public:
  Cantilever(const VectorX& frequencies, int modes)
      : Bench(Vector3::Zero(), [&](SystemGraph& graph) {
          const int n = static_cast<int>(frequencies.size());
          auto basis = std::make_shared<ModalBasis>();
          basis->name = "cantilever of cubic elements";
          basis->diagonal = true;
          basis->modal_mass = MatrixX::Identity(n, n).sparseView();
          basis->stiffness = MatrixX(frequencies.cwiseAbs2().asDiagonal()).sparseView();
          InertiaIntegrals I;
          I.mass = kDensity * kSide * kSide * kLength;
          I.J0 << I.mass, I.mass, I.mass, 0, 0, 0;
          I.Ct = Matrix3X::Zero(3, modes), I.C0 = I.Ct;
          I.J1 = Matrix6X::Zero(6, modes);
          I.J2 = MatrixX::Zero(6 * modes, modes);
          I.C1 = MatrixX::Zero(3 * modes, modes);
          I.Mff = MatrixX::Identity(modes, modes);
          auto& beam = graph.add<FlexibleBody>(
              "beam",
              FlexibleBody::Parameters{.basis = basis, .mode_count = modes, .modal_velocities = VectorX::Ones(modes)},
              I);
          graph.add<FixedJoint>("weld", {graph.ground().marker(), beam.frame()});
        }) {}
};

constexpr int kSteps = 1500;  // a mode 0.02 % beyond the limit grows ten-fold in energy

bool is_stable(Integrator& method, const VectorX& frequencies, int modes, double h) {
  Cantilever scene(frequencies, modes);
  return scene.run(method, kSteps * h, {}, 20 * scene.energy()).reached;
}
double limit(const VectorX& frequencies, int modes) {
  const double fastest = frequencies[modes - 1];
  return largest_stable_step(
      [&](double h) {
        ExplicitIndex1 method({.step = h});
        return is_stable(method, frequencies, modes, h);
      },
      2 / fastest, 4 / fastest, 2e-4);
}

Finding beyond() {
  std::vector<Figure> figures;
  const double published[] = {2.8301, 2.8303, 2.83, 2.83};
  for (int i = 0; i < 4; ++i) {
    const int elements = 4 << i, modes = 2 * elements;
    const VectorX frequencies = frequencies_of(elements);
    figures.push_back({"h ω_max bisected, " + std::to_string(elements) + " elements",
                       limit(frequencies, modes) * frequencies[modes - 1], published[i], 3});
  }
  ExplicitIndex1 method({.step = 2.9 / frequencies_of(4)[7]});
  const bool stable = is_stable(method, frequencies_of(4), 8, 2.9 / frequencies_of(4)[7]);
  return {stable ? Outcome::converged : Outcome::unstable, figures, "imaginary-axis limit, 2 √2"};
}

Finding below() {
  std::vector<Figure> figures;
  const double published[] = {1.42e4, 5.72e4, 2.29e5, 9.15e5};
  bool stable = true;
  double largest_step = NAN, spread[2] = {};
  for (int i = 0; i < 4; ++i) {
    const int elements = 4 << i;
    const VectorX frequencies = frequencies_of(elements);
    const double fastest = frequencies[2 * elements - 1];
    ExplicitIndex1 method({.step = 2.82 / fastest});
    stable = stable && is_stable(method, frequencies, 2 * elements, 2.82 / fastest);
    figures.push_back({"ω_max of " + std::to_string(elements) + " elements, rad/s", fastest, published[i], 3});
    if (i == 0) spread[0] = fastest / frequencies[0];
    if (i == 3) spread[1] = fastest / frequencies[0], largest_step = 2.828 / fastest;
  }
  figures.push_back({"ω_max/ω_1 of 4 elements", spread[0], 270});
  figures.push_back({"of 32 elements", spread[1], 17400, 3});
  return {stable ? Outcome::converged : Outcome::unstable, figures, "but the step is set by modes nobody looks at",
          largest_step};
}

Finding few_modes() {
  const VectorX frequencies = frequencies_of(32);
  const double h = limit(frequencies, 3);
  return {h * frequencies[2] > 2.8 ? Outcome::converged : Outcome::unstable,
          {{"largest stable step of three modes, s", h}, {"of all 64 modes, s", 2.828 / frequencies[63]}},
          "ω_max falls with the modes left out",
          h};
}

/// Three modes over a hundred periods of the first against their exact motion, of their amplitudes: all 64 are there,
/// the higher ones at rest.
Finding judge(Integrator& method) {
  const VectorX frequencies = frequencies_of(32);
  Cantilever scene(frequencies, 64);
  scene.state.v.tail(61).setZero();
  const auto course = scene.run(method, 10 * 2 * M_PI / frequencies[0]);
  if (!course.reached) return {Outcome::unstable, {{"stopped at, s", course.end}}, course.why};
  double error = 0;
  for (int k = 0; k < 3; ++k)
    error = std::max(error, std::abs(frequencies[k] * scene.state.q[7 + k] - std::sin(frequencies[k] * course.end)));
  return {judged(error, 1e-2, 10),
          {{"error of the three modes that move, of their amplitudes", error},
           {"steps", static_cast<double>(course.steps)}}};
}

const Registered scene{with_candidates(
    {"S20",
     "stiff elastic modes under explicit Runge-Kutta",
     {{"RK4 above h omega_max = 2.828", beyond}, {"RK4 below", below}, {"few modes kept, RK4", few_modes}}},
    {automatic(1e-4), radau(1e-5)}, {1e-4, 1e-3}, judge)};

}  // namespace
}  // namespace lithe::lab
