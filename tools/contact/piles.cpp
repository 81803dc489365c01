#include "tools/contact/piles.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <unordered_map>

#include "bodies/rigid_body.h"
#include "engine/assembly/evaluator.h"
#include "joints/contact/contact.h"

namespace lithe::contact_bench {
namespace {

constexpr double kGap = 0.05;  // between the cubes, m

/// How far two cubes overlap along the axis along which they do least; negative: a bound of their distance.
double overlap_of_cubes(const Motion& a, const Motion& b) {
  const Vector3 d = b.position - a.position;
  double least = INFINITY;
  const auto along = [&](const Vector3& axis) {
    const double length = axis.norm();
    if (length < 1e-6) return;  // parallel edges: the faces' normals tell
    const double reach =
        0.5 * kCube * ((a.axes.transpose() * axis).lpNorm<1>() + (b.axes.transpose() * axis).lpNorm<1>());
    least = std::min(least, (reach - std::abs(d.dot(axis))) / length);
  };
  for (int i = 0; i < 3; ++i) {
    along(a.axes.col(i));
    along(b.axes.col(i));
    for (int j = 0; j < 3; ++j) along(a.axes.col(i).cross(b.axes.col(j)));
  }
  return least;
}

double overlap_of_stack(const Motions& motions) {
  double deepest = 0;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const Motion& m = motions[i];
    deepest = std::max(deepest, 0.5 * kCube * m.axes.row(2).lpNorm<1>() - m.position[2]);  // its lowest corner
    for (std::size_t j = 0; j < i; ++j)
      if ((m.position - motions[j].position).norm() < std::sqrt(3.0) * kCube)
        deepest = std::max(deepest, overlap_of_cubes(m, motions[j]));
  }
  return deepest;
}

/// Spheres meet those in their own cell of a grid and the 26 around it.
double overlap_of_spheres(const Pile& pile, const Motions& motions) {
  double deepest = 0;
  const auto cell = [](double x) { return static_cast<std::int64_t>(std::floor(x / (2 * kRadius))); };
  const auto key = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return ((i + 65536) * 131072 + j + 65536) * 131072 + k + 65536;
  };
  std::unordered_map<std::int64_t, std::vector<const Vector3*>> cells;
  for (const Motion& m : motions) {
    const Vector3& p = m.position;
    deepest =
        std::max({deepest, kRadius - p[2], std::abs(p[0]) + kRadius - pile.wall, std::abs(p[1]) + kRadius - pile.wall});
    const std::int64_t i = cell(p[0]), j = cell(p[1]), k = cell(p[2]);
    for (int n = 0; n < 27; ++n) {
      const auto found = cells.find(key(i + n % 3 - 1, j + n / 3 % 3 - 1, k + n / 9 - 1));
      if (found == cells.end()) continue;
      for (const Vector3* other : found->second) deepest = std::max(deepest, 2 * kRadius - (p - *other).norm());
    }
    cells[key(i, j, k)].push_back(&p);
  }
  return deepest;
}

class LitheStepper final : public Stepper {
 public:
  LitheStepper(const Pile& pile, double step, const MakeIntegratorBy<const System&>& make)
      : step_(step),
        graph_({.gravity = {0, 0, -kGravity}}),
        system_((draw(graph_, pile), assemble(graph_))),
        equations_(system_),
        state_(system_.initial_state()),
        integrator_(make(system_)) {
    integrator_->start(equations_, state_);
  }
  void step() override {
    const StepResult result = integrator_->step(equations_, state_, state_.time + step_);
    if (!result.ok()) throw std::runtime_error(integrator_->name() + ": " + result.why);
  }
  void read(Motions& motions) const override {
    motions.clear();
    for (const auto& b : system_.layout().bodies()) {
      const Matrix3 A = rotation_matrix(state_.q.segment<4>(b.q + 3));
      motions.push_back({state_.q.segment<3>(b.q), state_.v.segment<3>(b.v), A * state_.v.segment<3>(b.v + 3), A});
    }
  }
  double iterations() const override {
    const IntegratorStatistics& s = integrator_->statistics();
    return s.steps > 0 ? static_cast<double>(s.newton_iterations) / static_cast<double>(s.steps) : 0;
  }

 private:
  double step_;
  SystemGraph graph_;
  System system_;
  Evaluator equations_;
  State state_;
  std::unique_ptr<Integrator> integrator_;
};

}  // namespace

Pile stack(const std::string& name, int count, double top_mass, double end) {
  Pile pile{name, end, true, 0, {}, std::vector<double>(static_cast<std::size_t>(count), 1.0)};
  pile.mass.back() = top_mass;
  for (int i = 0; i < count; ++i) pile.start.emplace_back(0, 0, kGap + 0.5 * kCube + i * (kCube + kGap));
  return pile;
}

Pile spheres(int count, double end) {
  const int side = static_cast<int>(std::ceil(std::cbrt(count)));
  const double pitch = 2.4 * kRadius;
  Pile pile{"spheres", end, false, 0.5 * side * pitch, {}, std::vector<double>(static_cast<std::size_t>(count), 1.0)};
  // A generator of its own (Numerical Recipes): every machine gets the same pile.
  std::uint32_t seed = 12345;
  const auto jitter = [&seed] {
    seed = seed * 1664525u + 1013904223u;
    return (static_cast<double>(seed >> 8) / 16777216 - 0.5) * 0.1 * kRadius;
  };
  for (int i = 0; i < count; ++i) {
    const Vector3 place((i % side + 0.5) * pitch - pile.wall, (i / side % side + 0.5) * pitch - pile.wall,
                        kRadius + 0.2 + i / (side * side) * pitch);
    const double x = jitter(), y = jitter(), z = jitter();
    pile.start.push_back(place + Vector3(x, y, z));
  }
  return pile;
}

double energy(const Pile& pile, const Motions& motions) {
  double sum = 0;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const Motion& m = motions[i];
    sum += pile.mass[i] * (0.5 * m.velocity.squaredNorm() + kGravity * m.position[2]) +
           0.5 * pile.inertia(i) * m.spin.squaredNorm();
  }
  return sum;
}

double overlap(const Pile& pile, const Motions& motions) {
  return pile.cubes ? overlap_of_stack(motions) : overlap_of_spheres(pile, motions);
}

int tunnelled(const Pile& pile, const Motions& motions) {
  return static_cast<int>(std::ranges::count_if(motions, [&](const Motion& m) {
    const double sideways = m.position.head<2>().cwiseAbs().maxCoeff();
    return !(m.position[2] > 0) || (!pile.cubes && !(sideways < pile.wall));
  }));
}

void draw(SystemGraph& graph, const Pile& pile) {
  std::vector<Collider> colliders{{graph.ground().marker(), shape::half_space()}};
  if (!pile.cubes)
    for (const double side : {-1.0, 1.0}) {
      const double quarter = -side * M_PI / 2;  // z of the wall inwards
      colliders.push_back(
          {graph.ground().marker({side * pile.wall, 0, 0}, rotation_about({0, 1, 0}, quarter)), shape::half_space()});
      colliders.push_back(
          {graph.ground().marker({0, side * pile.wall, 0}, rotation_about({1, 0, 0}, -quarter)), shape::half_space()});
    }
  const Shape shape = pile.cubes ? shape::box(Vector3::Constant(kCube)) : shape::sphere(kRadius);
  for (std::size_t i = 0; i < pile.start.size(); ++i) {
    auto& body = graph.add<RigidBody>(
        "body " + std::to_string(i),
        {.mass = pile.mass[i], .inertia = Vector3(Vector3::Constant(pile.inertia(i))), .position = pile.start[i]});
    colliders.push_back({body.marker(), shape});
  }
  graph.add<Contact>("pile", std::move(colliders), {.friction = {.coefficient = kFriction}});
}

std::unique_ptr<Stepper> lithe_stepper(const Pile& pile, double step, const MakeIntegratorBy<const System&>& make) {
  return std::make_unique<LitheStepper>(pile, step, make);
}

}  // namespace lithe::contact_bench
