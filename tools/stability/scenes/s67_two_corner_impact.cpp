// S67: a block that rocks on its corners (C04, Housner): where the other corner hits, the old one must be free to lift.
#include "tools/stability/methods/held_contacts.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/contacts.h"

namespace lithe::lab {
namespace {

const Vector3 kEdges(0.2, 0.2, 0.6);                                             // m
constexpr double kExact = 0.85, kLimit = 0.01, kEnd = 1.45;                      // -, relative, s
constexpr double kTimes[] = {0.273859, 0.666851, 0.973757, 1.221769, 1.425834};  // s: of the first five impacts

/// Released at rest, tilted about a corner by half the angle at which it would fall over.
class Block : public Bench {
 public:
  Block()
      : Bench({0, 0, -kGravity}, [](SystemGraph& graph) {
          const Matrix3 R = rotation_about(Vector3::UnitY(), 0.5 * std::atan2(kEdges[0], kEdges[2]));
          auto& block = graph.add<RigidBody>("block", {.mass = 1,
                                                       .inertia = box_inertia(kEdges, 1),
                                                       .position = R * Vector3(-0.5 * kEdges[0], 0, 0.5 * kEdges[2]),
                                                       .orientation = R});
          graph.add<Contact>("floor",
                             {{graph.ground().marker(), shape::half_space()}, {block.marker(), shape::box(kEdges)}},
                             {.law = RigidSurfaces{}, .friction = {.coefficient = 1}});
        }) {}
  double tilt() const { return 2 * std::atan2(state.q[5], state.q[3]); }
  double rate() const { return state.v[4]; }
};

struct Impact {
  double time, before, after;  // s, rad/s
};

/// An impact is a loss of rate by more than gravity's in a step, near the upright.
std::vector<Impact> rock(Integrator& method) {
  constexpr double kNearUpright = 0.01, kLoss = 0.03, kSlow = 0.1;  // rad, relative, rad/s
  Block block;
  std::vector<Impact> impacts;
  double last = 0;
  bool going_on = false;
  const auto course = block.run(method, kEnd, [&] {
    const double rate = std::abs(block.rate());
    const bool hit = std::abs(block.tilt()) < kNearUpright && last > kSlow && rate < (1 - kLoss) * last;
    if (hit && !going_on) impacts.push_back({block.state.time, last, rate});
    if (hit) impacts.back().after = rate;
    going_on = hit;
    last = rate;
  });
  if (!course.reached) impacts.clear();
  return impacts;
}

Finding judge(Integrator& method, const std::string& why) {
  const std::vector<Impact> impacts = rock(method);
  if (impacts.empty()) return {Outcome::unstable, {{"impacts", 0}}, "no impact was seen"};
  const double ratio = impacts.front().after / impacts.front().before;
  const int compared = std::min(5, static_cast<int>(impacts.size()));
  double late = 0;
  for (int i = 0; i < compared; ++i) late = std::max(late, std::abs(impacts[i].time - kTimes[i]));
  return {judged(ratio / kExact - 1, kLimit),
          {{"rate after the first impact over that before", ratio},
           {"error of their times, up to five, s", late},
           {"impacts to 1.45 s", static_cast<double>(impacts.size())}},
          why};
}

const Registered scene{under_every_method(
    {"S67",
     "two-corner impact",
     {{"both corners at once",
       [] {
         return judge(*moreau(2e-4, std::make_unique<HeldContacts>()), "stops dead: the old corner is not let go");
       }},
      {"hitting corner only",
       [] {
         Finding finding = judge(*moreau(5e-5), "complementarity: the old corner lifts");
         finding.figures.front().published = kExact;
         return finding;
       }},
      {"Moreau-Jean, h = 2e-4", [] { return judge(*moreau(2e-4), ""); }, Role::ours},
      {"nonsmooth generalized-alpha, h = 2e-4", [] { return judge(*nonsmooth_alpha(2e-4), ""); }, Role::ours}}},
    {1e-6, 2e-4}, [](Integrator& method) { return judge(method, ""); })};

}  // namespace
}  // namespace lithe::lab
