// Linkages, each drawn with every choice of catalogue joints that leaves it mobile, in random orientation:
// whichever rows repeat others, and wherever on the way that changes, the motion is that of the plainest drawing.
#include <gtest/gtest.h>

#include <random>

#include "engine/observe/snapshot.h"
#include "integrators/automatic.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "integrators/lie_bdf.h"
#include "integrators/radau.h"
#include "tests/reference/linkages.h"
#include "tests/support/linear_algebra.h"
#include "tests/support/methods.h"

namespace lithe::test::every_drawing_test {
namespace {

constexpr int kLooks = 8;
constexpr double kTolerance = 1e-8;

/// Middles of the links in the linkage's own plane, at kLooks times.
using Track = std::vector<Vector3>;

struct Outcome {
  Track track;
  double gap = 0, reaction = 0;
  bool ok = true;
  std::string why;
};

/// G at a state, dense.
MatrixX dense_rows(const Scene& scene, const State& state) {
  const int nv = scene.system.layout().v_count(), rows = scene.system.layout().row_count();
  Evaluator equations(scene.system);
  equations.evaluate(state.time, state.q, state.v, Level::velocity);
  equations.factorize({0, 0, 1}, VectorX::Zero(nv), VectorX::Zero(rows), nullptr);
  MatrixX G = MatrixX::Zero(rows, nv);
  equations.visit_blocks([&](int row, int column, ConstMatrixRef block) {
    if (row >= nv && column < nv) G.block(row - nv, column, block.rows(), block.cols()) += block;
  });
  return G;
}

/// λ of least norm that makes the same forces, by singular values; rows that a singular pose frees are left out of the
/// comparison: false.
bool least_norm(Scene& scene, VectorX& lambda) {
  const MatrixX G = dense_rows(scene, scene.state);
  const Eigen::JacobiSVD<MatrixX> svd(G, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorX s = svd.singularValues();
  const int rank = scene.system.rank();
  if (s[rank - 1] < 1e-3) return false;
  const MatrixX U = svd.matrixU().leftCols(rank);
  lambda = U * (U.transpose() * lambda);
  return true;
}

Outcome run(Scene& scene, Integrator& integrator, const Matrix3& turn, double duration, bool reactions) {
  Outcome out;
  const int bodies = static_cast<int>(scene.system.layout().bodies().size());
  integrator.start(scene.equations, scene.state);
  for (int k = 1; k <= kLooks; ++k) {
    const double end = duration * k / kLooks;
    while (scene.state.time < end) {
      const StepResult result = integrator.step(scene.equations, scene.state, end);
      if (!result.ok()) {
        out.ok = false, out.why = "t = " + std::to_string(scene.state.time) + ": " + result.why;
        return out;
      }
      out.gap = std::max(out.gap, scene.violation(Level::position));
    }
    for (int b = 0; b < bodies; ++b) out.track.push_back(turn.transpose() * scene.position(b));
    if (!reactions) continue;
    Snapshot now(scene.system, scene.state);
    VectorX mine = now.multipliers(), least = mine;
    if (least_norm(scene, least))
      out.reaction = std::max(out.reaction, (mine - least).norm() / std::max(1.0, least.norm()));
  }
  return out;
}

/// I(θ) θ̈ + ½ I' θ̇² + V' = 0 by Runge-Kutta steps of 1e-5 of the run, for linkages that pass poses where branches
/// meet: their own angle knows nothing of those.
template <class Acceleration, class Place>
Track exact_track(double angle, double speed, double duration, Acceleration&& rate, Place&& place) {
  Track out;
  const int steps = 100000;
  const double h = duration / steps;
  for (int i = 1; i <= steps; ++i) {
    const double k1 = rate(angle, speed), k2 = rate(angle + h / 2 * speed, speed + h / 2 * k1),
                 k3 = rate(angle + h / 2 * speed + h * h / 4 * k1, speed + h / 2 * k2),
                 k4 = rate(angle + h * speed + h * h / 2 * k2, speed + h * k3);
    angle += h * speed + h * h / 6 * (k1 + k2 + k3), speed += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    if (i % (steps / kLooks) == 0) place(Vector3(std::cos(angle), std::sin(angle), 0), out);
  }
  return out;
}

/// Uprights of 0.25 m that turn alike: I = 5/3 m r², V = 2 m g r sin θ.
Track parallelogram_track(double duration) {
  static constexpr double r = 0.25;
  return exact_track(
      0.9, 8, duration, [](double angle, double) { return -1.2 * 9.81 / r * std::cos(angle); },
      [](const Vector3& e, Track& out) {
        const Vector3 across(0.6, 0, 0);
        for (const Vector3& p : {Vector3(r / 2 * e), Vector3(r * e + across / 2), Vector3(r / 2 * e + across)})
          out.push_back(p);
      });
}

/// Link of 2 a at the angle -θ: I = m a² (5/3 + 4 sin² θ), V = 3/2 m g a sin θ.
Track scott_russell_track(double duration) {
  static constexpr double a = 0.3;
  return exact_track(
      0.7, 8, duration,
      [](double angle, double speed) {
        const double s = std::sin(angle), c = std::cos(angle);
        return -(1.5 * 9.81 / a * c + 4 * s * c * speed * speed) / (5.0 / 3 + 4 * s * s);
      },
      [](const Vector3& e, Track& out) {
        for (const Vector3& p : {Vector3(a / 2 * e), Vector3(a * e), Vector3(2 * a * e.x(), 0, 0)}) out.push_back(p);
      });
}

struct Candidate {
  std::string name;
  Method method;
  double allowed;  // m
};

/// Step limit: 0 (none), a fiftieth, a five-hundredth of the run.
std::vector<Candidate> candidates(double max_step, double duration) {
  const Tolerance tolerance{.relative = kTolerance, .absolute = kTolerance};
  std::vector<Candidate> out;
  out.push_back({"automatic",
                 std::make_unique<Automatic>(Automatic::Parameters{.tolerance = tolerance, .max_step = max_step}),
                 1e-5});
  out.push_back(
      {"radau", std::make_unique<Radau>(Radau::Parameters{.tolerance = tolerance, .max_step = max_step}), 1e-5});
  out.push_back(
      {"bdf", std::make_unique<LieBdf>(LieBdf::Parameters{.tolerance = tolerance, .max_step = max_step}), 1e-4});
  out.push_back(
      {"rk8",
       std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{
           .method = ExplicitRungeKutta::Method::dormand_prince8, .tolerance = tolerance, .max_step = max_step}),
       1e-5});
  out.push_back(
      {"alpha",
       std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{
           .step = max_step > 0 ? max_step / 10 : duration / 2000, .spectral_radius = 0.9, .newton_tolerance = 1e-12}),
       1e-2});
  return out;
}

class EveryDrawing : public ::testing::TestWithParam<Linkage (*)()> {};

TEST_P(EveryDrawing, MovesAsThePlainestOne) {
  const Linkage linkage = GetParam()();
  const std::vector<Vector6> velocities = start_velocities(linkage);
  const Matrix3 flat = Matrix3::Identity();
  const std::vector<Drawing> all = all_drawings(linkage);
  const Track exact = linkage.name == "parallelogram" ? parallelogram_track(linkage.duration)
                      : linkage.name == "scott-russell"
                          ? scott_russell_track(linkage.duration)
                          : [&] {
                              Scene scene = draw(linkage, all.front(), flat, velocities);
                              return run(scene, *runge_kutta8(1e-11), flat, linkage.duration, false).track;
                            }();
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const double limits[] = {0, linkage.duration / 50, linkage.duration / 500};
  const bool everything = std::getenv("LITHE_EVERY_DRAWING") != nullptr;  // else a method and a limit each, in turn
  const Scene plain = draw(linkage, all.front(), flat, velocities);
  const int repeated = plain.system.layout().row_count() - plain.system.rank();
  int count = 0, mobile = 0, runs = 0, failed = 0;
  for (const Drawing& drawing : all) {
    const Matrix3 turn =
        rotation_matrix(Vector4(normal(random), normal(random), normal(random), normal(random)).normalized());
    ++count;
    // A freedom that nothing holds (a body that spins, a motion out of the plane) may be unstable: not asked for.
    if (freedoms_added(drawing) - freedoms_added(all.front()) > repeated) continue;
    if (draw(linkage, drawing, turn, velocities).system.degrees_of_freedom() != 1) continue;
    ++mobile;
    for (int l = 0; l < 3; ++l) {
      std::vector<Candidate> methods = candidates(limits[l], linkage.duration);
      for (int m = 0; m < static_cast<int>(methods.size()); ++m) {
        Candidate& c = methods[m];
        if (!everything && (mobile % 3 != l || mobile % 5 != m)) continue;
        Scene scene = draw(linkage, drawing, turn, velocities);
        const Outcome got = run(scene, *c.method, turn, linkage.duration, c.name == "rk8");
        ++runs;
        double off = 0;
        for (std::size_t i = 0; i < got.track.size(); ++i) off = std::max(off, (got.track[i] - exact[i]).norm());
        if (got.ok && off <= c.allowed && got.gap <= 1e-9 && got.reaction <= 1e-8) continue;
        ++failed;
        ADD_FAILURE() << linkage.name << ' ' << drawing.name() << ", " << c.name << ", limit " << limits[l] << ": "
                      << got.why << " off " << off << " m, |g| " << got.gap << ", reactions " << got.reaction;
      }
    }
  }
  std::printf("%s: %d drawings, %d with one freedom, %d runs, %d failed\n", linkage.name.c_str(), count, mobile, runs,
              failed);
  EXPECT_GT(runs, 10);
}

INSTANTIATE_TEST_SUITE_P(Linkages, EveryDrawing,
                         ::testing::Values(slider_crank, four_bar, scott_russell, parallelogram, scissor, bricard,
                                           bennett),
                         [](const auto& at) {
                           std::string name = at.param().name;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace lithe::test::every_drawing_test
