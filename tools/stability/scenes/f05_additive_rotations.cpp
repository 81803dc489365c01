// F05: a beam whose nodal rotation vectors are interpolated additively feels a turn of the whole as strain (M. A.
// Crisfield, G. Jelenic, Proc. R. Soc. A 455 (1999) 1125).
#include "bodies/beam/beam.h"
#include "engine/observe/snapshot.h"
#include "tools/stability/lab.h"

namespace lithe::lab {
namespace {

constexpr double kLength = 1, kLimit = 1e-10;
const Vector3 kBent(0.4, -0.9, 1.1);  // by how much the beam turns from end to end, rad
const Vector3 kAxis = Vector3(1, -2, 2) / 3;
constexpr double kTurns[] = {0.2, 0.5, 0.8, 1, 1.2};  // of the whole, about that axis, rad; none passes half a turn

Matrix3 orientation(double share) { return rotation_exp(Vector3(share * kBent)); }

/// The curvature of an element in its middle, from θ = (θ_A + θ_B)/2, θ' = (θ_B - θ_A)/L.
Vector3 additive_curvature(const Matrix3& A, const Matrix3& B, double length) {
  const Vector3 a = rotation_log(A), b = rotation_log(B);
  return right_jacobian_inverse(Vector3((a + b) / 2)).inverse() * (b - a) / length;
}

/// Largest change by the turns, relative.
double additive(int elements) {
  double most = 0;
  for (int e = 0; e < elements; ++e) {
    const Matrix3 A = orientation(static_cast<double>(e) / elements), B = orientation((e + 1.0) / elements);
    const Vector3 still = additive_curvature(A, B, kLength / elements);
    for (const double turn : kTurns) {
      const Matrix3 Q = rotation_exp(Vector3(turn * kAxis));
      most = std::max(most, (additive_curvature(Q * A, Q * B, kLength / elements) - still).norm() / still.norm());
    }
  }
  return most;
}
/// What the library's beam makes of the same.
double exact(int elements) {
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  auto& beam = graph.add<Beam>("beam", {.axis = BeamAxis::straight({0, 0, 0}, {kLength, 0, 0}, {0, 1, 0}),
                                        .sections = {{0, BeamSection::circle(0.1, {2.1e11, 0.3, 7850})}},
                                        .elements = elements});
  const System system = assemble(graph);
  std::vector<Vector3> still;
  double most = 0;
  for (const double turn : {0.0, kTurns[0], kTurns[1], kTurns[2], kTurns[3], kTurns[4]}) {
    const Matrix3 Q = rotation_exp(Vector3(turn * kAxis));
    State state = system.initial_state();
    int node = 0;
    for (const auto& body : system.layout().bodies()) {
      if (!body.frame) continue;
      const double share = static_cast<double>(node++) / elements;
      state.q.segment<3>(body.q) = Q * Vector3(share * kLength, 0, 0);
      state.q.segment<4>(body.q + 3) = quaternion_of(Q * orientation(share));
    }
    Snapshot now(system, state);
    for (int e = 0; e < elements; ++e) {
      Vector6 strain;
      beam.strain(e).evaluate(now, {strain.data(), 6});
      const Vector3 curvature = strain.tail<3>();
      if (turn == 0) {
        still.push_back(curvature);
      } else {
        const Vector3& before = still[static_cast<std::size_t>(e)];
        most = std::max(most, (curvature - before).norm() / before.norm());
      }
    }
  }
  return most;
}

Finding finding(double changed, const std::string& why, std::vector<Figure> more = {}) {
  std::vector<Figure> figures{{"largest change of the curvature by turns of the whole, relative", changed}};
  figures.insert(figures.end(), more.begin(), more.end());
  return {judged(changed, kLimit), figures, why};
}

const Registered scene{
    {"F05",
     "additive interpolation of rotations",
     {{"rotation vectors interpolated, 2 elements",
       [] {
         return finding(additive(2), "the mean of two rotation vectors is no rotation between the two",
                        {{"1 element", additive(1)}});
       },
       Role::also},
      {"rotation vectors interpolated, 16 elements",
       [] {
         return finding(additive(16), "a finer mesh hides it with the square of the elements' length",
                        {{"32 elements over 16", additive(32) / additive(16), 0.25, 2}});
       },
       Role::also},
      {"beam, relative motion in SE(3), 2 elements",
       [] {
         return finding(exact(2), "strains are of the relative motion of the ends, in which a common turn cancels");
       },
       Role::ours}}}};

}  // namespace
}  // namespace lithe::lab
