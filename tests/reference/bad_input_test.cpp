// The list of broken inputs: each gives one typed error that says what, where and how to fix it.
#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>

#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/readers/calculix.h"
#include "bodies/flexible/readers/matrix_market.h"
#include "bodies/rigid_body.h"
#include "engine/assembly/system.h"
#include "engine/observe/recorder.h"
#include "engine/output/csv.h"
#include "engine/run/simulation.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "joints/distance_joint.h"
#include "joints/fixed_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/bodies/flexible_models.h"

namespace lithe::test::bad_input_test {
namespace {

namespace fs = std::filesystem;
const std::string kRod = std::string(LITHE_EXAMPLE_DATA) + "/pendulum/hex8i/";
const double kNaN = std::numeric_limits<double>::quiet_NaN();

struct BrokenInput {
  std::string name;
  std::string says;  // part of the message, in lower or upper case as printed
  std::function<void()> run;
};

/// A copy of the rod's files with one text replaced (first occurrence), or cut short.
std::string broken_rod(const std::string& file, const std::function<std::string(std::string)>& damage) {
  const fs::path folder = fs::temp_directory_path() / ("lithe_bad_" + std::to_string(::getpid()));
  fs::remove_all(folder);
  fs::copy(kRod, folder, fs::copy_options::recursive);
  std::ifstream in(folder / file);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  in.close();
  std::ofstream(folder / file) << damage(text);
  return folder.string() + "/";
}
std::function<std::string(std::string)> replace(std::string what, std::string by) {
  return [what, by](std::string text) { return text.replace(text.find(what), what.size(), by); };
}
std::function<std::string(std::string)> cut(double share) {
  return [share](std::string text) {
    return text.substr(0, static_cast<std::size_t>(share * static_cast<double>(text.size())));
  };
}
FiniteElementModel read(const std::string& folder) {
  return read_matrix_market(folder + "K.mtx", folder + "M.mtx", folder + "nodes.csv", folder + "node_sets.csv");
}
const FiniteElementModel& rod() {
  static const FiniteElementModel model = pendulum_model("hex8i");
  return model;
}
FiniteElementModel changed_rod(const std::function<void(FiniteElementModel&)>& change) {
  FiniteElementModel model = rod();
  change(model);
  return model;
}

struct Swing {  // one body on one ball
  SystemGraph graph;
  RigidBody& body = graph.add<RigidBody>("body", {});
};

std::vector<BrokenInput> list() {
  return {
      {"a missing file", "nowhere", [] { read_calculix("nowhere/matrices"); }},
      {"a truncated stiffness matrix", "K.mtx", [] { read(broken_rod("K.mtx", cut(0.5))); }},
      {"a truncated CalculiX matrix", "matrices.mas",
       [] { read_calculix(broken_rod("calculix/matrices.mas", cut(0.5)) + "calculix/matrices"); }},
      {"a word among the numbers", "nodes.csv:2",
       [] { read(broken_rod("nodes.csv", replace("1,0.0,0.0,0.0", "1,0.0,zero,0.0"))); }},
      {"NaN in a matrix", "nan", [] { read(broken_rod("M.mtx", replace("0.0006", "nan"))); }},
      {"a wrong number of nodes", "nodes", [] { read(broken_rod("nodes.csv", cut(0.6))); }},
      {"a set that names a missing node", "999",
       [] { read(broken_rod("node_sets.csv", replace("hinge,1,1,", "hinge,1,999,"))); }},
      {"an asymmetric stiffness", "symmetr",
       [] { require_sound(changed_rod([](auto& m) { m.stiffness.coeffRef(0, 4) *= 1.5; })); }},
      {"zero mass", "mass", [] { require_sound(changed_rod([](auto& m) { m.mass *= 0; })); }},
      {"a stiffness that holds rigid motion", "rigid",
       [] { require_sound(changed_rod([](auto& m) { m.stiffness.coeffRef(0, 0) *= 2; })); }},
      {"an indefinite stiffness", "eigenvalue",
       [] { require_sound(changed_rod([](auto& m) { m.stiffness = -m.stiffness; })); }},
      {"an unknown node set", "hinge", [] { rod().node_set("pivot"); }},
      {"collinear frame nodes", "line",
       [] {
         make_basis(rod(), ThreeNodeFrame{1, 2, 3}, 3);
       }},
      {"more modes than coordinates", "modes", [] { make_basis(rod(), MeanAxisFrame{}, 500); }},
      {"a marker on a missing node", "777",
       [] {
         SystemGraph graph;
         graph.add<FlexibleBody>("rod", {.basis = make_basis(rod(), MeanAxisFrame{}, 2)}).node(777);
       }},
      {"a body without basis", "basis",
       [] {
         SystemGraph graph;
         graph.add<FlexibleBody>("rod", {});
       }},
      {"a body with more modes than its basis", "mode_count",
       [] {
         SystemGraph graph;
         graph.add<FlexibleBody>("rod", {.basis = make_basis(rod(), MeanAxisFrame{}, 2), .mode_count = 3});
       }},
      {"negative damping", "damping",
       [] {
         SystemGraph graph;
         graph.add<FlexibleBody>(
             "rod", {.basis = make_basis(rod(), MeanAxisFrame{}, 2), .damping = {.mass_proportional = -1}});
       }},
      {"a body without mass", "mass",
       [] {
         SystemGraph graph;
         graph.add<RigidBody>("body", {.mass = 0});
       }},
      {"the inertia of no real body", "inertia",
       [] {
         SystemGraph graph;
         graph.add<RigidBody>("body", {.inertia = {1, 1, 3}});
       }},
      {"a parameter that is not finite", "velocity",
       [] {
         SystemGraph graph;
         graph.add<RigidBody>("body", {.velocity = {0, kNaN, 0}});
       }},
      {"an orientation that is no rotation", "rotation",
       [] {
         SystemGraph graph;
         graph.add<RigidBody>("body", {.orientation = 2 * Matrix3::Identity()});
       }},
      {"a name used twice", "in use",
       [] {
         SystemGraph graph;
         graph.add<RigidBody>("body", {});
         graph.add<RigidBody>("body", {});
       }},
      {"a joint with too few markers", "markers",
       [] {
         Swing s;
         s.graph.add<SphericalJoint>("pin", {s.body.marker()});
       }},
      {"a disconnected joint", "disconnected",
       [] {
         Swing s;
         s.graph.add<SphericalJoint>("pin", {s.body.marker(), Marker{}});
       }},
      {"a marker of another graph", "another graph",
       [] {
         Swing s, other;
         s.graph.add<SphericalJoint>("pin", {s.body.marker(), other.body.marker()});
       }},
      {"a joint between ground and ground", "ground",
       [] {
         Swing s;
         s.graph.add<SphericalJoint>("pin", {s.graph.ground().marker(), s.graph.ground().marker()});
         assemble(s.graph);
       }},
      {"an empty scene", "no body",
       [] {
         SystemGraph graph;
         assemble(graph);
       }},
      {"joints that cannot be closed", "cannot be assembled",
       [] {
         Swing s;
         s.graph.add<SphericalJoint>("here", {s.graph.ground().marker(), s.body.marker({0.5, 0, 0})});
         s.graph.add<SphericalJoint>("there", {s.graph.ground().marker({9, 0, 0}), s.body.marker({-0.5, 0, 0})});
         assemble(s.graph);
       }},
      {"a start off its constraints that is to be refused", "not consistent",
       [] {
         Swing s;
         s.graph.add<SphericalJoint>("pin", {s.graph.ground().marker({0.1, 0, 0}), s.body.marker()});
         assemble(s.graph, {.start = AssembleOptions::Start::refuse});
       }},
      {"a hinge whose axes point against each other", "axes",
       [] {
         Swing s;
         s.graph.add<RevoluteJoint>("pin",
                                    {s.graph.ground().marker(), s.body.marker({}, rotation_about({1, 0, 0}, M_PI))});
         assemble(s.graph);
       }},
      {"a rod of negative length", "length",
       [] {
         Swing s;
         s.graph.add<DistanceJoint>("rod", {s.graph.ground().marker(), s.body.marker()}, {.length = -1});
       }},
      {"a spectral radius of one", "spectral_radius", [] { GeneralizedAlpha({.step = 1e-3, .spectral_radius = 1}); }},
      {"a negative step", "step", [] { ExplicitRungeKutta({.step = -1e-3}); }},
      {"two columns of one name", "tip",
       [] {
         Swing s;
         Recorder recorder({height(s.body.marker(), "tip"), height(s.body.marker(), "tip")});
       }},
      {"a table with a broken row", ".csv:3",
       [] {
         const std::string path = (fs::temp_directory_path() / "lithe_bad_table.csv").string();
         std::ofstream(path) << "a,b\n1,2\n1,two\n";
         read_csv(path);
       }},
  };
}

class BadInput : public testing::TestWithParam<BrokenInput> {};

TEST_P(BadInput, gives_one_error_that_says_what_where_and_how_to_fix_it) {
  try {
    GetParam().run();
    FAIL() << "accepted silently";
  } catch (const Error& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find(GetParam().says), std::string::npos) << text;
    EXPECT_FALSE(error.problem().empty()) << text;
    EXPECT_FALSE(error.where().empty()) << text;
    EXPECT_FALSE(error.fix().empty()) << text;
    EXPECT_EQ(text.find("error: error:"), std::string::npos) << text;
  }
}

INSTANTIATE_TEST_SUITE_P(List, BadInput, testing::ValuesIn(list()), [](const auto& test) {
  std::string name = test.param.name;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
});

TEST(BrokenInputs, has_a_list_of_at_least_twenty) { EXPECT_GE(list().size(), 20u); }

}  // namespace
}  // namespace lithe::test::bad_input_test
