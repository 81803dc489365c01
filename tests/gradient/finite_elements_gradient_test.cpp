// E, density and thickness of a finite-element model, through its reduction.
#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/reduction.h"
#include "joints/revolute_joint.h"
#include "tests/gradient/gradient_support.h"

namespace lithe::test {
namespace {

/// A strip of bricks that swings about one end, in modes and in those with the shapes of its interface.
ParametricScene strip(const char* name, int modes, bool loaded, Deflection deflection) {
  return {.name = name,
          .duration = 0.03,
          .draw =
              [=](SystemGraph& graph, const SweepPoint& p) {
                const Matrix3 y = rotation_about({1, 0, 0}, -M_PI / 2);
                const FiniteElementModel mesh = brick_mesh({.size = {0.4, 0.03, p["thickness"]},
                                                            .divisions = {4, 1, 1},
                                                            .type = "C3D8I",
                                                            .material = {p["E"], 0.3, p["density"]}});
                const std::vector<int>&root = mesh.node_set("x_min"), &tip = mesh.node_set("x_max");
                Reduction reduction{.deflection = deflection};
                if (loaded) reduction.loaded = {{tip}};
                auto& arm = graph.add<FlexibleBody>(
                    "arm", {.basis = make_basis(mesh, MeanTangentFrame{{root}}, modes, reduction),
                            .damping = {.stiffness_proportional = 1e-3}});
                graph.add<RevoluteJoint>(
                    "hinge", {graph.ground().marker({0, 0.015, p["thickness"] / 2}, y), arm.average(root, y)});
                return std::vector<Sensor>{position(arm.average(tip), "tip"), elastic_energy(arm, "energy")};
              },
          .integrator = exact_alpha(5e-4)};
}
const std::vector<DesignParameter> kStrip{{"thickness", 5e-3}, {"E", 2e9}, {"density", 1200}};
/// Of each drawing Lanczos finds eigenpairs to 1e-10; drawings are a thousandth apart.
constexpr double kOfModes = 2e-6;
const std::vector<Quantity> kStripEnd{value_at("tip_z", 0.03), integral("energy")};

TEST(FiniteElementGradients, OfAStripInModes) {
  expect_gradient(strip("strip in modes", 2, false, Deflection::linear), kStripEnd, kStrip, kOfModes);
}
TEST(FiniteElementGradients, OfAStripWithItsInterface) {
  expect_gradient(strip("strip with its interface", 1, true, Deflection::linear), kStripEnd, kStrip, kOfModes);
}
TEST(FiniteElementGradients, OfAStiffenedStrip) {
  expect_gradient(strip("stiffened strip", 2, false, Deflection::stiffened), kStripEnd, kStrip, kOfModes);
}

}  // namespace
}  // namespace lithe::test
