// F06: the plane Reissner beam of two nodes with linear shapes: integrated fully it locks, in large deflections too.
#include <Eigen/LU>

#include "bodies/beam/beam.h"
#include "engine/analysis/equilibrium.h"
#include "engine/assembly/evaluated.h"
#include "joints/fixed_joint.h"
#include "joints/forces/point_force.h"
#include "tools/stability/bench.h"
#include "tools/stability/lab.h"

namespace lithe::lab {
namespace {

// A cantilever of length 1 and EI 1 under a load across its end of 2 EI/L²; L/h = 1000. Deflection without stretch and
// shear (elastica, by elliptic integrals).
constexpr double kLoad = 2, kSlender = 12e6, kExact = 0.4934574803967118, kLimit = 0.01;
constexpr double kShear = kSlender * 5 / 6 / 2.6;  // GA L²/EI, ν = 0.3

/// Deflection of the end by Newton, in load steps, with one or two Gauss points an element.
double tip(int elements, int points) {
  const int n = 3 * elements;  // x, y, θ of each node but the first
  const double h = 1.0 / elements, gauss = points == 2 ? 1 / std::sqrt(3.0) : 0;
  VectorX u = VectorX::Zero(n + 3);
  for (int i = 0; i <= elements; ++i) u[3 * i] = i * h;
  const Vector3 C(kSlender, kShear, 1);
  constexpr int kSteps = 40;
  for (int step = 1; step <= kSteps; ++step)
    for (int iteration = 0; iteration < 60; ++iteration) {
      MatrixX K = MatrixX::Zero(n + 3, n + 3);
      VectorX r = VectorX::Zero(n + 3);
      r[n + 1] = -kLoad * step / kSteps;
      for (int e = 0; e < elements; ++e)
        for (int p = 0; p < points; ++p) {
          const double xi = p ? gauss : -gauss, weight = h / points, a = (1 - xi) / 2, b = (1 + xi) / 2;
          const auto A = u.segment<3>(3 * e), B = u.segment<3>(3 * e + 3);
          const double dx = (B[0] - A[0]) / h, dy = (B[1] - A[1]) / h, angle = a * A[2] + b * B[2], c = std::cos(angle),
                       s = std::sin(angle);
          const Vector3 strain(c * dx + s * dy - 1, -s * dx + c * dy, (B[2] - A[2]) / h);
          // Derivatives of the strains by (x', y', θ), and what those are by the nodes; curvature apart.
          Eigen::Matrix<double, 3, 6> D = Eigen::Matrix<double, 3, 6>::Zero(), strains = D;
          D.row(0) << -1 / h, 0, 0, 1 / h, 0, 0;
          D.row(1) << 0, -1 / h, 0, 0, 1 / h, 0;
          D.row(2) << 0, 0, a, 0, 0, b;
          strains.row(0) = c * D.row(0) + s * D.row(1) + (-s * dx + c * dy) * D.row(2);
          strains.row(1) = -s * D.row(0) + c * D.row(1) - (c * dx + s * dy) * D.row(2);
          strains(2, 2) = -1 / h, strains(2, 5) = 1 / h;
          const Vector3 force = C.cwiseProduct(strain);
          r.segment<6>(3 * e) += weight * strains.transpose() * force;
          // Second derivatives: Γ₁ by (x', θ), (y', θ), (θ, θ): -s, c, -(1 + Γ₁); Γ₂: -c, -s, -Γ₂.
          Matrix3 second = Matrix3::Zero();
          second(0, 2) = second(2, 0) = -s * force[0] - c * force[1];
          second(1, 2) = second(2, 1) = c * force[0] - s * force[1];
          second(2, 2) = -(1 + strain[0]) * force[0] - strain[1] * force[1];
          K.block<6, 6>(3 * e, 3 * e) +=
              weight * (strains.transpose() * C.asDiagonal() * strains + D.transpose() * second * D);
        }
      const VectorX d = K.bottomRightCorner(n, n).partialPivLu().solve(-r.tail(n));
      u.tail(n) += d;
      if (d.cwiseAbs().maxCoeff() < 1e-10) break;
      if (!d.allFinite()) return NAN;
    }
  return u[n + 1];
}

double ours(int elements) {
  Marker end;
  Bench scene(Vector3::Zero(), [&](SystemGraph& graph) {
    auto& beam = graph.add<Beam>(
        "beam", {.axis = BeamAxis::straight({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                 .sections = {{0, BeamSection::diagonal({kSlender, kShear, kShear, 1, 1, 1}, 1, {2e-7, 1e-7, 1e-7})}},
                 .elements = elements});
    graph.add<FixedJoint>("clamp", {graph.ground().marker(), beam.marker(0)});
    graph.add<PointForce>("load", {end = beam.marker(1)}, {.force = {0, kLoad, 0}});
  });
  const State rest = find_equilibrium(scene.system, scene.state).state;
  scene.equations.evaluate(rest.time, rest.q, rest.v, Level::velocity);
  return marker_kinematics(scene.equations, end, Level::position).p.y();
}

template <class Tip>
Finding over_meshes(Tip&& tip, const std::string& why) {
  std::vector<Figure> figures;
  for (const int elements : {16, 64, 4})
    figures.push_back(
        {"deflection over the elastica's, " + std::to_string(elements) + " elements", tip(elements) / kExact});
  return {judged(figures[0].value - 1, kLimit), figures, why};
}

const Registered scene{
    {"F06",
     "full integration of a flexible beam",
     {{"linear shapes, two Gauss points",
       [] {
         return over_meshes([](int n) { return tip(n, 2); },
                            "shear that linear shapes cannot avoid, (element/thickness)² too stiff");
       },
       Role::also},
      {"linear shapes, one Gauss point",
       [] { return over_meshes([](int n) { return tip(n, 1); }, "shear is sampled where it can vanish"); }, Role::also},
      {"beam, helical elements", [] { return over_meshes(ours, "its shapes bend without shear"); }, Role::ours}}}};

}  // namespace
}  // namespace lithe::lab
