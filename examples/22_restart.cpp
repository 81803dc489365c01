// 22_restart: a double pendulum, chaotic, is cut off in the middle of its run and goes on from its checkpoint.
//
// Shows: checkpoints during a run, rows written to disk as they come, resume(), and what a changed scene is told.
// Expect: the resumed run ends with the very bits of the run that nothing interrupted, rows and all.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "lithe/lithe.h"

using namespace lithe;

namespace {

/// An observer of one's own: the highest speed of the tip so far. What it keeps goes into checkpoints too.
class TopSpeed final : public Observer {
 public:
  explicit TopSpeed(Marker tip) : speed_(velocity(tip)) {}
  void observe(Snapshot& now) override {
    top_ = std::max(top_, std::hypot(speed_.value(now, 0), speed_.value(now, 1), speed_.value(now, 2)));
  }
  void history(Archive& archive) override { archive("top speed", top_); }
  double top() const { return top_; }

 private:
  Sensor speed_;
  double top_ = 0;
};

/// All that a program needs to begin, or to begin again: the same lines for both.
struct Pendulum {
  SystemGraph graph;
  RigidBody& upper =
      graph.add<RigidBody>("upper", {.mass = 1, .inertia = {1e-3, 0.02, 0.02}, .position = {0.25, 0, 0}});
  RigidBody& lower;
  const Marker end = lower.marker({0.25, 0, 0});
  System system{assembled()};
  Automatic integrator{{.tolerance = {.relative = 1e-8, .absolute = 1e-8}}};
  Simulation simulation{system, integrator};
  Recorder tip{{position(end, "tip")}};
  TopSpeed speed{end};

  Pendulum(const std::string& folder, double lower_mass = 0.7)
      : lower(graph.add<RigidBody>("lower",
                                   {.mass = lower_mass, .inertia = {1e-3, 0.015, 0.015}, .position = {0.75, 0, 0}})) {
    tip.stream(folder + "/tip.csv");
    simulation.observe(tip, every(0.01));
    simulation.observe(speed, every(0.01));
    simulation.checkpoint(folder + "/checkpoint.h5", every(0.1));
  }
  System assembled() {
    const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);  // marker z along world y
    graph.add<RevoluteJoint>("hook", {graph.ground().marker({0, 0, 0}, along_y), upper.marker({-0.25, 0, 0}, along_y)});
    graph.add<RevoluteJoint>("elbow", {upper.marker({0.25, 0, 0}, along_y), lower.marker({-0.25, 0, 0}, along_y)});
    return assemble(graph);
  }
};

}  // namespace

int main() {
  const std::string folder = "results/restart";
  std::filesystem::remove_all(folder);

  // 1. The run as it should be.
  Pendulum whole(folder + "/whole");
  State expected = whole.system.initial_state();
  whole.simulation.run(expected, 10);

  // 2. The same, cut off after 4.321 s: what is left of it are two files.
  {
    Pendulum first(folder + "/resumed");
    State state = first.system.initial_state();
    first.simulation.run(state, 4.321);
  }

  // 3. A new program draws the same scene, and goes on where the last checkpoint was written.
  Pendulum second(folder + "/resumed");
  State state = second.simulation.resume(folder + "/resumed/checkpoint.h5");
  std::printf("goes on from t = %.6f s, with %d rows\n", state.time, second.tip.table().row_count());
  second.simulation.run(state, 10);

  // 4. In another scene the checkpoint is of no use, and says so.
  bool refused = false;
  try {
    Pendulum heavier(folder + "/heavier", 0.71);
    heavier.simulation.resume(folder + "/resumed/checkpoint.h5");
  } catch (const SceneError& error) {
    refused = true;
    std::printf("%s\n", error.what());
  }

  // 5. Check the answer: no bit differs, in the state nor in the file.
  const bool same_state = same(state, expected);
  const bool same_rows = read_csv(folder + "/resumed/tip.csv").values == read_csv(folder + "/whole/tip.csv").values;
  const bool same_top = second.speed.top() == whole.speed.top();
  std::printf("at 10 s: state %s, rows %s, top speed %s: %.3f m/s\n", same_state ? "the same bits" : "another one",
              same_rows ? "the same" : "others", same_top ? "too" : "another", second.speed.top());
  return refused && same_state && same_rows && same_top ? 0 : 1;
}
