// S65: ten cubes on one another (C03), at rest for 20 s; also with 100 kg on top, and on a slope of
// 4 degrees. (On the 20 of C03 friction would hold it, but it topples: beyond 5.7, its width over its height.)
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/contacts.h"

namespace lithe::lab {
namespace {

constexpr double kEdge = 0.1, kFriction = 0.5, kEnd = 20, kStep = 1.0 / 240, kLimit = 1e-6;  // m, -, s, s, m
constexpr int kCubes = 10;

class Stack : public Bench {
 public:
  Stack(double top, double slope)
      : Bench(kGravity * Vector3(std::sin(slope), 0, -std::cos(slope)), [&](SystemGraph& graph) {
          std::vector<Collider> colliders{{graph.ground().marker(), shape::half_space()}};
          const Vector3 edges = Vector3::Constant(kEdge);
          for (int i = 0; i < kCubes; ++i) {
            const double mass = i == kCubes - 1 ? top : 1;
            auto& cube = graph.add<RigidBody>(
                "cube" + std::to_string(i),
                {.mass = mass, .inertia = box_inertia(edges, mass), .position = {0, 0, (i + 0.5) * kEdge}});
            colliders.push_back({cube.marker(), shape::box(edges)});
          }
          graph.add<Contact>("cubes", colliders, {.law = RigidSurfaces{}, .friction = {.coefficient = kFriction}});
        }) {}
};

/// Of the cube that moves most, m.
double displacement(double top, double slope, Integrator& method) {
  Stack stack(top, slope);
  const VectorX start = stack.state.q;
  double most = 0;
  const auto course = stack.run(method, kEnd, [&] {
    for (int i = 0; i < kCubes; ++i)
      most = std::max(most, (stack.state.q.segment<3>(7 * i) - start.segment<3>(7 * i)).norm());
  });
  return course.reached ? most : NAN;
}

Finding judge(const std::function<Method()>& make, const std::string& why) {
  const double equal = displacement(1, 0, *make()), heavy = displacement(100, 0, *make()),
               slope = displacement(1, 4 * M_PI / 180, *make());
  const double worst = std::isfinite(equal + heavy + slope) ? std::max({equal, heavy, slope}) : NAN;
  return {judged(worst, kLimit),
          {{"largest displacement in 20 s, m", worst},
           {"equal masses", equal},
           {"100 kg on top", heavy},
           {"slope of 4 deg", slope}},
          why};
}

const Registered scene{under_every_method(
    {"S65",
     "stack",
     {{"fixed-sweep Gauss-Seidel",
       [] {
         return judge(
             [] { return moreau(kStep, std::make_unique<GaussSeidel>(GaussSeidel::Parameters{.sweeps = 10})); },
             "ten sweeps a step, h = 1/240 s");
       },
       Role::published, Cost::slow},
      {"direct or converged",
       [] { return judge([] { return moreau(kStep, std::make_unique<DirectConeSolver>()); }, "h = 1/240 s"); },
       Role::published, Cost::slow},
      {"Moreau-Jean, h = 1/240 s", [] { return judge([] { return moreau(kStep); }, ""); }, Role::ours, Cost::slow},
      {"nonsmooth generalized-alpha, h = 1/240 s", [] { return judge([] { return nonsmooth_alpha(kStep); }, ""); },
       Role::ours, Cost::slow}}},
    {1e-6, kStep}, [](const std::function<Method()>& make) { return judge(make, ""); })};

}  // namespace
}  // namespace lithe::lab
