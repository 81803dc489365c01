// Checkpoints whose content was changed behind their digest (tools/fuzz/checkpoint_targets.cpp does so by chance).
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <span>
#include <type_traits>

#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "integrators/lie_bdf.h"
#include "integrators/moreau_jean.h"
#include "tests/integrators/restart_scenes.h"
#include "tests/support/message_of.h"

namespace lithe::test::hostile_checkpoint_test {
namespace {

using namespace restart;

/// What resuming says of a run's checkpoint in which one integer is another: that of the list `name`, at `place`.
std::string refusal(const std::function<void(SystemGraph&)>& draw, const MakeMethod& make, const std::string& name,
                    std::size_t place, int value) {
  Machine run(draw, make);
  run.simulation.run(run.state, 0.4);
  Archive saved;
  run.simulation.save(run.state, saved);
  Archive::Content content = saved.content();
  std::size_t first = 0;
  for (std::size_t i = 0; i < content.names.size(); ++i) {
    const int* shape = content.shapes.data() + 3 * i;
    if (shape[0] != 1) continue;  // of numbers, or texts
    if (content.names[i] == name) {
      EXPECT_LT(place, static_cast<std::size_t>(shape[1])) << name;
      content.integers[2 * (first + place)] = value;
      content.integers[2 * (first + place) + 1] = 0;
    }
    first += static_cast<std::size_t>(shape[1]) * static_cast<std::size_t>(shape[2]);
  }
  EXPECT_NE(content.integers, saved.content().integers) << name;
  Archive changed("changed", std::move(content));
  Machine resumed(draw, make);
  return message_of<Error>([&] { resumed.simulation.resume(changed); });
}

void expect_said(const std::string& message, const std::string& part) {
  EXPECT_NE(message.find(part), std::string::npos) << message;
}

const MakeMethod kRigid = of<MoreauJean>({.step = 1e-3});

TEST(HostileCheckpoint, with_more_contacts_than_it_holds_is_refused_before_room_is_made_for_them) {
  expect_said(refusal(draw_rigid_contact, kRigid, "state/contacts/count", 0, std::numeric_limits<int>::max()),
              "does not fit the contacts that it holds");
}

TEST(HostileCheckpoint, with_a_contact_of_surfaces_that_there_are_not_is_refused) {
  constexpr std::size_t kCollider = 2, kNodeCount = 3;  // behind the law and the element
  for (const int collider : {-1, 3, 77})
    expect_said(refusal(draw_rigid_contact, kRigid, "state/contacts/integers", kCollider, collider),
                "a contact that this scene does not have");
  expect_said(refusal(draw_rigid_contact, kRigid, "state/contacts/integers", kNodeCount, 4),
              "a contact that this scene does not have");
  expect_said(refusal(draw_rigid_contact, kRigid, "state/contacts/integers", 1, 5), "does not fit the scene");
}

TEST(HostileCheckpoint, of_a_multistep_method_of_an_order_that_there_is_not_is_refused) {
  const auto draw = [](SystemGraph& graph) { draw_loop(graph, {}); };
  for (const int order : {-7, 6, 99})
    expect_said(refusal(draw, of<LieBdf>({.tolerance = kTolerance}), "method/order", 0, order),
                "order " + std::to_string(order));
}

/// The numbers, or the integers, of the list `name`.
template <class Value>
std::span<Value> list_of(std::vector<Value>& all, const Archive::Content& content, const std::string& name) {
  constexpr int kKind = std::is_same_v<Value, double> ? 0 : 1, kHalves = kKind + 1;
  std::size_t first = 0;
  for (std::size_t i = 0; i < content.names.size(); ++i) {
    const int* shape = content.shapes.data() + 3 * i;
    if (shape[0] != kKind) continue;
    const std::size_t size = static_cast<std::size_t>(kHalves * shape[1]) * static_cast<std::size_t>(shape[2]);
    if (content.names[i] == name) return {all.data() + first, size};
    first += size;
  }
  ADD_FAILURE() << "no list " << name;
  return {};
}

/// A block and a ball that land on the floor, whose gaps are watched: a value of the wrong sign is an event that never
/// happened, and one far from its level that is said to have been dealt with repeats itself at each step.
TEST(HostileCheckpoint, whose_values_of_events_are_forged_goes_on_as_the_sound_one) {
  for (const MakeMethod& make : {of<ExplicitRungeKutta>({.tolerance = kTolerance}),
                                 of<LieBdf>({.tolerance = kTolerance}), of<GeneralizedAlpha>({.step = 1e-3})}) {
    Machine run(draw_compliant, make);
    run.simulation.run(run.state, 0.012);
    Archive saved;
    run.simulation.save(run.state, saved);
    run.simulation.run(run.state, 0.03);
    EXPECT_FALSE(run.simulation.events().empty());
    for (const auto& forge : std::vector<std::function<double(double)>>{
             [](double x) { return -x; }, [](double x) { return 2 * x; }, [](double) { return 0.0; },
             [](double) { return std::numeric_limits<double>::quiet_NaN(); },
             [](double x) { return std::copysign(std::numeric_limits<double>::infinity(), x); },
             [](double) { return 1e-300; }})
      for (const int trend : {0, 1}) {
        Archive::Content content = saved.content();
        for (double& value : list_of(content.numbers, saved.content(), "events/values")) value = forge(value);
        const auto trends = list_of(content.integers, saved.content(), "events/by_trend");
        for (std::size_t i = 0; i < trends.size(); i += 2) trends[i] = trend;
        Archive forged("forged", std::move(content));
        Machine resumed(draw_compliant, make);
        resumed.state = resumed.simulation.resume(forged);
        resumed.simulation.run(resumed.state, 0.03);
        EXPECT_TRUE(same(resumed.state, run.state)) << run.method->name() << " by trend: " << trend;
        EXPECT_EQ(resumed.simulation.statistics().steps, run.simulation.statistics().steps);
        EXPECT_EQ(resumed.simulation.events().size(), run.simulation.events().size());
      }
  }
}

TEST(HostileCheckpoint, that_approaches_a_switch_that_there_is_not_is_refused) {
  for (const int watched : {-2, 0, 99})  // 0: an event
    expect_said(
        refusal(draw_compliant, of<ExplicitRungeKutta>({.tolerance = kTolerance}), "events/approached", 0, watched),
        "approaches a switch");
}

}  // namespace
}  // namespace lithe::test::hostile_checkpoint_test
