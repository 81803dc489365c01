#include "engine/page/page.h"
#include "engine/run/simulation.h"
#include "integrators/generalized_alpha.h"
#include "tests/engine/page/page_reader.h"
#include "tests/support/message_of.h"

namespace lithe::test::page {
namespace {

/// A field at all nodes of the rod, in memory and read back from a stream, at the points that the page draws.
TEST(MeshField, ColoursABodyByWhatStaysTheSame) {
  for (const bool streams : {false, true}) {
    const ScratchFolder folder;
    RodScene scene(Deflection::linear);
    const System system = assemble(scene.graph);
    State state = system.initial_state();
    GeneralizedAlpha integrator{{.step = 1e-3, .spectral_radius = 0.8}};
    Simulation simulation(system, integrator);
    lithe::Run run{system};
    if (streams) run.stream(folder.path("run.h5"));
    const VectorX damage = VectorX::LinSpaced(scene.rod->basis().nodes.cols(), 1e-6, 0.3);
    expect_says(message_of<SceneError>([&] { run.add(*scene.rod, {"damage", "", damage}); }), {"observed no state"});
    simulation.observe(run, every(0.1));
    simulation.run(state, 0.2);
    run.add(*scene.rod, {"damage", "", damage});
    run.add(*scene.rod, {"range", "Pa", 1e6 * damage});
    write_page(run, folder.path("rod.html"));
    const Page page(folder.path("rod.html"));
    const Json& fields = page.body("rod").at("mesh").at("fields");
    ASSERT_EQ(fields.size(), 2u);
    EXPECT_EQ(fields[0].at("name"), "damage");
    EXPECT_EQ(fields[1].at("unit"), "Pa");
    const VectorX drawn = page.array(fields[0].at("values"), 1).transpose();
    EXPECT_LT((drawn - damage(scene.rod->drawn_mesh(false).nodes)).cwiseAbs().maxCoeff(), 1e-7);

    expect_says(message_of<SceneError>([&] {
                  run.add(*scene.rod, {"few", "", VectorX::Ones(3)});
                }),
                {"3 values for the nodes of 'rod'", "'few'"});
    expect_says(message_of<SceneError>([&] { run.add(*scene.rod, {"bad", "", std::nan("") * damage}); }), {"'bad'"});
    expect_says(message_of<SceneError>([&] {
                  run.add(scene.graph.ground(), {"none", "", damage});
                }),
                {"'ground' draws no mesh"});
  }
}

}  // namespace
}  // namespace lithe::test::page
