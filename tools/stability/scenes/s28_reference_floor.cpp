// S28: published vectors are right to fewer digits than they print: an error curve against them flattens.
#include "tools/scenes/squeezer.h"
#include "tools/stability/bench.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

using Vector = std::vector<double>;

/// What a problem's publication has, and the reference: binary128 or 80 bit, proved twice (the problem files).
struct Problem {
  std::string name;
  Vector published, reference;
};
const std::vector<Problem>& problems() {
  static const std::vector<Problem> all{
      {"R03, angles at 0.03 s",
       {15.81077119629904, -15.75637105984298, 0.04082224013073101, -0.5347301163226948, 0.5244099658805304,
        0.5347301163226948, 1.048080741042263},
       {1.581077119515370732e1, -1.57563710584118386e1, 4.08222401196458029e-2, -5.347301163420795644e-1,
        5.24409965879954032e-1, 5.347301163420795644e-1, 1.048080741041937936}},
      {"F01, velocities at 0.1 s (projected start)",
       {0.6025346755138369e2, -0.8753116326670527e1, -0.3005541400289738e-1, -0.5500431812571696e-2,
        0.4974111734266989e-3, 0.1105560003626645e-2},
       {6.0253467551318352e1, -8.7531163267041627, -3.0055413998525571e-2, -5.5004318013328448e-3,
        4.9741117946464802e-4, 1.1055599936031179e-3}},
      {"R14, positions at 3 s",
       {0.0493455784275402809122, 0.496989460230171153861, 1.04174252488542151681, 0.373911027265361256927},
       {4.934557842752409357e-2, 4.969894602300081177e-1, 1.04174252488542618, 3.739110272653657918e-1}},
      {"R15, positions at 10 s",
       {0.86355386965811e-2, 0.13038281022727e-4, -0.93635784016818e-4, -0.13642299804033e-1, 0.15292895005422e-2},
       {8.635538251534e-3, 1.303834113684e-5, -9.36358113991e-5, -1.364229597015e-2, 1.529289421512e-3}}};
  return all;
}

double largest_relative(const Vector& actual, const Vector& expected) {
  double worst = 0;
  for (std::size_t i = 0; i < actual.size(); ++i) worst = std::max(worst, std::abs(actual[i] / expected[i] - 1));
  return worst;
}

/// R03: Andrews' squeezer.
class Squeezer : public Bench {
 public:
  Squeezer()
      : Bench(Vector3::Zero(), [](SystemGraph& graph) { scenes::draw_squeezer(graph, scenes::kSqueezerStart); }) {}

  /// β, Θ, γ, Φ, δ, Ω, ε, whole turns of the crank as in the reference.
  Vector angles() const {
    const auto turned = [&](int body) {
      const Vector3 x = rotation_matrix(state.q.segment<4>(7 * body + 3)).col(0);
      return std::atan2(x.y(), x.x());
    };
    const Vector& at = problems()[0].reference;
    const double sums[] = {at[0], at[0] + at[1], at[2], at[3] + at[4], at[4], at[5] + at[6], at[6]};
    double K[7];
    for (int i = 0; i < 7; ++i) K[i] = sums[i] + std::remainder(turned(i) - sums[i], 2 * M_PI);
    return {K[0], K[1] - K[0], K[2], K[3] - K[4], K[4], K[5] - K[6], K[6]};
  }
};

const Vector& squeezed() {
  static const Vector angles = [] {
    Squeezer scene;
    scene.run(*runge_kutta8(1e-13).make(), 0.03);
    return scene.angles();
  }();
  return angles;
}

Finding against_published() {
  const double error = largest_relative(squeezed(), problems()[0].published);
  // The orders of the published floors; R03's and F01's are of the components listed.
  const double floors[] = {1e-10, 1e-8, 1e-12, NAN};
  std::vector<Figure> figures{{"R03 at tolerance 1e-13 against the published angles, relative", error, 1e-10, 0}};
  for (std::size_t i = 0; i < problems().size(); ++i)
    figures.push_back({"published against reference, " + problems()[i].name,
                       largest_relative(problems()[i].published, problems()[i].reference), floors[i], 0});
  return {judged(error, 1e-11), figures, "published digits"};
}
Finding against_reference() {
  const double error = largest_relative(squeezed(), problems()[0].reference);
  return {judged(error, 1e-11),
          {{"R03 at tolerance 1e-13 against the reference, relative", error}},
          "as far as double precision goes"};
}
Finding judge(Integrator& method) {
  Squeezer scene;
  if (!scene.run(method, 0.03).reached) return {Outcome::unstable, {}, "stopped early"};
  const double error = largest_relative(scene.angles(), problems()[0].reference);
  return {judged(error, 1e-11), {{"R03 against the reference, relative", error}}};
}

const Registered scene{with_candidates({"S28",
                                        "reference floor",
                                        {{"compared with the published vectors", against_published},
                                         {"compared with the tables here", against_reference}}},
                                       {automatic(1e-12)}, {1e-12, 1e-5}, judge)};

}  // namespace
}  // namespace lithe::lab
