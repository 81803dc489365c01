// Elements and material must give the model's K: measured on its entries, whatever the shape of the body and its modes.
#include <gtest/gtest.h>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/elements/solid_element.h"
#include "bodies/flexible/reduction.h"
#include "engine/base/error.h"
#include "tests/bodies/fe_models.h"

namespace lithe::test::stiffness_of_elements_test {
namespace {

/// 8 m long with a side of 18 mm. Its bending modes are what is left where entries of K cancel: compared among the
/// first one or two, elements and K differ by 3e-5 of the largest modal stiffness, all of it round-off.
FiniteElementModel slender() {
  return brick_mesh({.size = {8, 0.018, 0.018},
                     .divisions = {40, 1, 1},
                     .type = "C3D20",
                     .material = {.young = 7e10, .poisson = 0.3, .density = 2700}});
}

TEST(StiffnessOfElements, of_a_slender_solid_is_told_by_few_modes_as_by_many) {
  const FiniteElementModel model = slender();
  // Round-off of the same entries, summed in another order: some tens of 1e-16, and 8 m / 18 mm for the positions.
  EXPECT_LT(stiffness_difference(model).largest, 1e-12);
  for (int modes : {1, 2, 12})
    EXPECT_NO_THROW(
        make_basis(model, TangentFrame{model.node_set("x_min")}, modes, {.deflection = Deflection::stiffened}))
        << modes;
}

TEST(StiffnessOfElements, of_another_material_is_refused_with_few_modes_as_with_many) {
  for (auto change : {+[](Material& m) { m.poisson *= 1.001; }, +[](Material& m) { m.poisson *= 0.999; },
                      +[](Material& m) { m.young *= 0.999; }, +[](Material& m) { m.young *= 1.001; }}) {
    FiniteElementModel model = slender();
    change(model.elements[0].material);
    EXPECT_GT(stiffness_difference(model).largest, 2e-4);
  }
  FiniteElementModel stiffer = slender();
  stiffer.elements[0].material.young *= 1.001;
  for (int modes : {1, 12})
    expect_error<SceneError>(
        [&] {
          make_basis(stiffer, TangentFrame{stiffer.node_set("x_min")}, modes, {.deflection = Deflection::stiffened});
        },
        {"do not give the stiffness matrix", "at node"});
}

TEST(StiffnessOfElements, of_one_element_among_many_is_found_and_named) {
  FiniteElementModel model = slender();
  ElementBlock one = model.elements[0];
  one.nodes = {model.elements[0].nodes.back()};
  model.elements[0].nodes.pop_back();
  one.material.young *= 1.001;
  model.elements.push_back(one);
  const auto [largest, node] = stiffness_difference(model);
  EXPECT_GT(largest, 2e-4);
  EXPECT_LT(largest, 1.1e-3);
  EXPECT_NE(std::find(one.nodes[0].begin(), one.nodes[0].end(), node), one.nodes[0].end()) << node;
}

TEST(StiffnessOfElements, of_entries_that_k_lacks_counts_too) {
  FiniteElementModel model = slender();
  model.stiffness.prune([](Eigen::Index row, Eigen::Index column, double) { return row / 3 == column / 3; });
  EXPECT_GT(stiffness_difference(model).largest, 0.1);
}

TEST(StiffnessOfElements, of_files_is_as_exact_as_their_digits) {
  for (const char* mesh : {"hex8i", "hex20"}) {
    const double largest = stiffness_difference(pendulum_from_calculix(mesh)).largest;
    EXPECT_LT(largest, 1e-9) << mesh;
  }
}

}  // namespace
}  // namespace lithe::test::stiffness_of_elements_test
