// Checkpoints: a file of any bytes, and a sound one's content with entries that the input changes, which no digest can
// stop. It is refused, or resumed into a run that stays finite.
#include <optional>

#include "bodies/rigid_body.h"
#include "engine/base/error.h"
#include "engine/observe/observer_schedules.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "integrators/lie_bdf.h"
#include "integrators/moreau_jean.h"
#include "joints/contact/contact.h"
#include "joints/revolute_joint.h"
#include "tools/fuzz/script.h"
#include "tools/fuzz/targets.h"

namespace lithe::fuzz {
namespace {

/// A pendulum, a ball on the floor, an event and a recorder: each part of a checkpoint has something to hold.
class CheckpointScene {
 public:
  explicit CheckpointScene(int method) {
    auto& rod = graph_.add<RigidBody>("rod", {.mass = 1, .inertia = {0.01, 0.1, 0.1}, .position = {0.5, 0, 2}});
    graph_.add<RevoluteJoint>("pin", {graph_.ground().marker({0, 0, 2}, kAlongY), rod.marker({-0.5, 0, 0}, kAlongY)});
    auto& ball = graph_.add<RigidBody>(
        "ball", {.mass = 1, .inertia = {4e-3, 4e-3, 4e-3}, .position = {0, 0, 0.099}, .velocity = {0.1, 0, 0}});
    Contact::Parameters contact{.friction = {.coefficient = 0.3}};
    if (method == kMethods - 1)
      contact.law = RigidSurfaces{};
    else
      contact.law = Compliance{.stiffness = 1e4, .exponent = 1}, contact.friction.bristle_stiffness = 3e3;
    graph_.add<Contact>("touch", {{graph_.ground().marker(), shape::half_space()}, {ball.marker(), shape::sphere(0.1)}},
                        std::move(contact));
    system_.reset(new System(assemble(graph_)));
    recorder_.emplace(std::vector<Sensor>{height(rod.marker(), "rod")});
    switch (method) {
      case 0:
        integrator_ = std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{});
        break;
      case 1:
        integrator_ = std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.step = 1e-3});
        break;
      case 2:
        integrator_ = std::make_unique<LieBdf>(LieBdf::Parameters{});
        break;
      default:
        integrator_ = std::make_unique<MoreauJean>(MoreauJean::Parameters{.step = 1e-3});
    }
    simulation_.emplace(*system_, *integrator_);
    simulation_->observe(*recorder_, every(5e-3));
    simulation_->on({.name = "swung", .function = [](Snapshot& now) { return now.state().v[4] - 0.1; }});
  }

  Archive::Content saved() {
    State state = system_->initial_state();
    simulation_->run(state, 0.02);
    Archive archive;
    simulation_->save(state, archive);
    return archive.content();
  }
  void write(const std::string& path) {
    State state = system_->initial_state();
    simulation_->run(state, 0.02);
    simulation_->save(state, path);
  }
  template <class Source>
  void resume(Source&& source) {
    State state = simulation_->resume(source);
    // A state far away in time moves on by what time can resolve.
    const double end = state.time + std::max(5e-3, 100 * time_round_off(state.time));
    simulation_->run(state, end);
    demand(state.q.allFinite() && state.v.allFinite(), "a resumed run ends at a state that is not finite");
    recorder_->table();
  }

  static constexpr int kMethods = 4;

 private:
  static inline const Matrix3 kAlongY = rotation_about({1, 0, 0}, -M_PI / 2);
  SystemGraph graph_{{.gravity = {0, 0, -9.81}}};
  std::unique_ptr<System> system_;
  std::unique_ptr<Integrator> integrator_;
  std::optional<Recorder> recorder_;
  std::optional<Simulation> simulation_;
};

/// Entry of a list, none where it is empty.
template <class Value>
Value* entry(std::vector<Value>& all, std::size_t index) {
  return all.empty() ? nullptr : &all[index % all.size()];
}

void checkpoint(std::string_view input, const std::filesystem::path&) {
  FuzzScript script(input);
  const int method = script.byte() % CheckpointScene::kMethods;
  static std::optional<Archive::Content> sound[CheckpointScene::kMethods];
  if (!sound[method]) sound[method] = CheckpointScene(method).saved();
  Archive::Content content = *sound[method];
  while (!script.ended()) {
    const std::uint8_t what = script.byte();
    const auto index = script.raw<std::uint16_t>();
    switch (what % 8) {
      case 0:
        if (double* x = entry(content.numbers, index)) *x = script.number(0);
        break;
      case 1:
        if (double* x = entry(content.numbers, index)) *x = script.raw<double>();
        break;
      case 2:
        if (int* x = entry(content.integers, index)) *x = script.integer(1);
        break;
      case 3:
        if (int* x = entry(content.shapes, index)) *x = script.integer(2);
        break;
      case 4:
        if (std::string* x = entry(content.names, index)) *x += static_cast<char>(script.byte());
        break;
      case 5:
        if (std::string* x = entry(content.texts, index)) *x += static_cast<char>(script.byte());
        break;
      case 6:  // a vector that has grown or shrunk, and what it lists with it
        if (int* x = entry(content.shapes, 3 * (index % (content.shapes.size() / 3)) + 1)) {
          const int grown = script.integer(1);
          if (grown < 0 || grown > 65 || *x < 0) break;
          std::size_t first = 0;
          const int kind = x[-1];
          for (const int* s = content.shapes.data(); s + 1 < x; s += 3)
            if (s[0] == kind) first += static_cast<std::size_t>(s[1]) * static_cast<std::size_t>(s[2]);
          // Shapes may have been forged before.
          const auto lies_within = [&](std::size_t count) {
            return first <= count && static_cast<std::size_t>(*x) <= count - first;
          };
          if (kind == 0 && x[1] == 1 && lies_within(content.numbers.size())) {
            const auto at = content.numbers.begin() + static_cast<std::ptrdiff_t>(first);
            content.numbers.insert(content.numbers.erase(at, at + *x), static_cast<std::size_t>(grown), 0.5);
            *x = grown;
          } else if (kind == 1 && lies_within(content.integers.size() / 2)) {
            const auto at = content.integers.begin() + static_cast<std::ptrdiff_t>(2 * first);
            content.integers.insert(content.integers.erase(at, at + 2 * *x), 2 * static_cast<std::size_t>(grown), 0);
            *x = grown;
          }
        }
        break;
      default:  // cut
        content.numbers.resize(std::min<std::size_t>(content.numbers.size(), index));
    }
  }
  Archive archive("fuzzed", std::move(content));
  CheckpointScene(method).resume(archive);
}

void checkpoint_file(std::string_view input, const std::filesystem::path& folder) {
  CheckpointScene(0).resume(file_of(input, folder, "run.h5"));
}

}  // namespace

void write_checkpoint_seed(const std::string& path) { CheckpointScene(0).write(path); }

std::vector<Target> checkpoint_targets() { return {{"checkpoint", checkpoint}, {"checkpoint_file", checkpoint_file}}; }

}  // namespace lithe::fuzz
