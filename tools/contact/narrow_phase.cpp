// How exact are our contacts, and what do they cost? Writes the table of docs/contact.md: each pair of shapes in 2000
// random poses, 10 m from the origin, 1e-6 to 0.1 m deep (or to where the pair's answer is known), and as many apart.
#include <cstdio>

#include "tests/joints/contact_pairs.h"
#include "tools/bench/measure.h"

using namespace lithe;
using namespace lithe::test;

namespace {

struct Worst {
  double depth = 0, normal = 0, point = 0, seconds = 0;
  int missed = 0;
};

Worst measure(const ContactPair& pair, bool apart) {
  constexpr int kPoses = 2000, kRepeats = 5;
  ContactScene scene({pair.a, pair.b});
  scene.reach = {0.1, 0.05};
  Random random(7);
  Worst worst;
  for (int i = 0; i < kPoses; ++i) {
    const double most = apart ? 0.1 : pair.deepest;
    const double depth = (apart ? -1 : 1) * std::pow(10.0, uniform(random, -6, std::log10(most)));
    ContactPose a, b;
    const Vector3 touch = pair.place(depth, random, a, b);
    const ContactPose common = random_pose(random, 10);
    scene.poses.set(0, common * a);
    scene.poses.set(1, common * b);
    double fastest = 1;  // of a few: the machine does other things too
    for (int repeat = 0; repeat < kRepeats; ++repeat) {
      const double start = bench::wall_seconds();
      for (int k = 0; k < 4; ++k) scene.find();
      fastest = std::min(fastest, (bench::wall_seconds() - start) / 4);
    }
    worst.seconds += fastest / kPoses;
    const ContactPoint* deepest = nullptr;
    for (const ContactPoint& p : scene.points)
      if (deepest == nullptr || p.gap < deepest->gap) deepest = &p;
    if (deepest == nullptr) {
      ++worst.missed;
      continue;
    }
    const Vector3 truth = common.R.col(2);
    worst.depth = std::max(worst.depth, std::abs(deepest->gap + depth));
    worst.normal = std::max(worst.normal, deepest->normal.cross(truth).norm() + (deepest->normal.dot(truth) < 0));
    const Vector3 off = deepest->position - common.p - common.R * touch;
    const double away = (off - off.dot(truth) * truth).norm();
    if (!(away <= worst.point)) worst.point = away;
  }
  return worst;
}

}  // namespace

int main() {
  std::printf("| pair | poses | ns a query | depth error (m) | normal error (rad) | point error (m) | missed |\n");
  std::printf("|---|---|---|---|---|---|---|\n");
  for (const ContactPair& pair : contact_pairs())
    for (bool apart : {false, true}) {
      if (!apart && pair.deepest == 0) continue;
      const Worst w = measure(pair, apart);
      std::printf("| %s | %s | %.0f | %.1e | %.1e | ", pair.name.c_str(), apart ? "apart" : "deep", w.seconds * 1e9,
                  w.depth, w.normal);
      if (std::isnan(w.point))
        std::printf("| %d |\n", w.missed);
      else
        std::printf("%.1e | %d |\n", w.point, w.missed);
    }
}
