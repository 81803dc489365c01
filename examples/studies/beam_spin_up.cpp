// Spin-up of a cantilever (the beam and the motion of benchmark F03, variant A: Simo & Vu-Quoc 1988), four bending
// modes, to 3 rad/s instead of 6. A body that is linear in its deformation is not stiffened by the spin: beyond its
// first frequency, 3.80 rad/s, it bends without bound, whatever the integrator. Below it the model is a good test of
// integrators, not of the beam.  lithe chart beam_spin_up
#include "lithe/lithe.h"

using namespace lithe;

namespace {

constexpr double kLength = 10, kBending = 1.4e4, kLine = 1.2, kRotary = 6e-4;  // m, N m², kg/m, kg m
constexpr int kStations = 40;
constexpr double kRoots[] = {1.8751040687, 4.6940911330, 7.8547574382, 10.9955407349};  // of cos x cosh x = -1

/// Deflection and slope of a cantilever's mode, ∫ w² = L.
std::array<double, 2> mode(double root, double x) {
  const double z = root * x / kLength;
  const double s = (std::cosh(root) + std::cos(root)) / (std::sinh(root) + std::sin(root));
  return {std::cosh(z) - std::cos(z) - s * (std::sinh(z) - std::sin(z)),
          root / kLength * (std::sinh(z) + std::sin(z) - s * (std::cosh(z) - std::cos(z)))};
}

/// Four mass points a station, off the axis by the section's radius of gyration: sections turn with the slope.
std::shared_ptr<const ModalBasis> beam() {
  const int count = 4 * (kStations + 1), modes = static_cast<int>(std::size(kRoots));
  const double r = std::sqrt(kRotary / kLine);
  Matrix3X nodes(3, count);
  SparseMatrix mass(count, count), stiffness(modes, modes);
  MatrixX B = MatrixX::Zero(3 * count, modes);
  for (int i = 0; i < count; ++i) {
    const int station = i / 4;
    const double x = kLength * station / kStations, y = i % 2 ? r : -r;
    nodes.col(i) = Vector3(x, y, i % 4 < 2 ? r : -r);
    const double share = station == 0 || station == kStations ? 0.5 : 1;  // trapezoidal rule
    mass.insert(i, i) = share * kLine * kLength / kStations / 4;
    for (int k = 0; k < modes; ++k) {
      const auto [w, slope] = mode(kRoots[k], x);
      B(3 * i, k) = -y * slope;
      B(3 * i + 1, k) = w;
    }
  }
  for (int k = 0; k < modes; ++k) stiffness.insert(k, k) = kBending * kLength * std::pow(kRoots[k] / kLength, 4);
  return basis_from_modes("cantilever", nodes, mass, stiffness, B);
}

/// θ = (Ω/T) (t²/2 + (T/2π)² (cos(2πt/T) - 1)): the speed grows smoothly to Ω in T.
Motion spin_up(double t) {
  const double speed = 3, T = 15, w = 2 * M_PI / T;
  if (t >= T) return {speed * (t - T / 2), speed, 0};
  return {speed / T * (t * t / 2 + (std::cos(w * t) - 1) / (w * w)), speed / T * (t - std::sin(w * t) / w),
          speed / T * (1 - std::cos(w * t))};
}

}  // namespace

StudyScene scene() {
  return {.name = "spin-up of a beam to 3 rad per s",
          .duration = 20,
          .gravity = {0, 0, 0},
          .characteristic_length = kLength,
          .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
            auto& rod = graph.add<FlexibleBody>("beam", {.basis = beam()});
            auto& hub = graph.add<RevoluteJoint>("hub", {graph.ground().marker(), rod.frame()});
            graph.add<CoordinateDrive>("motor", {hub.angle()}, {.motion = spin_up});
            return {position(rod.node(4 * kStations + 1), "tip")};
          }};
}
