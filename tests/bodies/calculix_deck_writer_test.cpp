#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/readers/calculix_deck.h"
#include "tests/bodies/fe_models.h"

namespace lithe::test::calculix_deck_writer_test {
namespace {

constexpr Material kSteel{2.07e11, 0.3, 7800}, kRubber{3e6, 0.48, 1100};

class CalculixDeckWriter : public testing::Test {
 protected:
  const std::string path_ =
      testing::TempDir() + "written_deck_" + testing::UnitTest::GetInstance()->current_test_info()->name() + ".inp";
  ~CalculixDeckWriter() override { std::filesystem::remove(path_); }
};

/// Edges that no short decimal number holds.
FiniteElementModel block(const std::string& type) {
  return brick_mesh({.size = {1.0 / 3, 0.02 * M_PI, 0.01}, .divisions = {3, 2, 1}, .type = type, .material = kSteel});
}

TEST_F(CalculixDeckWriter, WhatIsReadBackIsTheSameModelToTheLastBit) {
  for (const char* type : {"C3D4", "C3D8", "C3D8I", "C3D10", "C3D20", "C3D20R"}) {
    SCOPED_TRACE(type);
    const FiniteElementModel model = block(type);
    write_calculix_deck(path_, model);
    const FiniteElementModel read = read_calculix_mesh(path_);
    EXPECT_EQ(read.node_ids, model.node_ids);
    EXPECT_EQ(read.nodes, model.nodes);
    EXPECT_EQ(read.node_sets, model.node_sets);
    ASSERT_EQ(read.elements.size(), 1u);
    EXPECT_EQ(read.elements[0].type, type);
    EXPECT_EQ(read.elements[0].nodes, model.elements[0].nodes);
    EXPECT_EQ(read.stiffness.nonZeros(), model.stiffness.nonZeros());
    EXPECT_EQ(SparseMatrix(read.stiffness - model.stiffness).norm(), 0);
    EXPECT_EQ(SparseMatrix(read.mass - model.mass).norm(), 0);
    EXPECT_GT(model.stiffness.norm(), 1e8);
  }
}

TEST_F(CalculixDeckWriter, LabelsAndMaterialsAreKept) {
  FiniteElementModel model = block("C3D8I");
  for (int& id : model.node_ids) id = 1000 - 3 * id;
  for (auto& [set, nodes] : model.node_sets)
    for (int& id : nodes) id = 1000 - 3 * id;
  ElementBlock soft{"C3D8I", {model.elements[0].nodes.back()}, kRubber};
  model.elements[0].nodes.pop_back();
  model.elements.push_back(soft);
  assemble_matrices(model);
  write_calculix_deck(path_, model);
  const FiniteElementModel read = read_calculix_mesh(path_);
  EXPECT_EQ(read.node_ids, model.node_ids);
  EXPECT_EQ(read.node_sets, model.node_sets);
  ASSERT_EQ(read.elements.size(), 2u);
  EXPECT_EQ(read.elements[1].material.young, kRubber.young);
  EXPECT_EQ(read.elements[1].material.poisson, kRubber.poisson);
  EXPECT_EQ(read.elements[1].material.density, kRubber.density);
  EXPECT_LT(SparseMatrix(read.stiffness - model.stiffness).norm(), 1e-15 * model.stiffness.norm());
  EXPECT_LT(SparseMatrix(read.mass - model.mass).norm(), 1e-15 * model.mass.norm());
}

/// CalculiX reads at most 16 entries a line, and wants the rest of an element of 20 nodes on the next.
TEST_F(CalculixDeckWriter, LinesAreThoseOfCalculix) {
  write_calculix_deck(path_, block("C3D20"));
  std::ifstream deck(path_);
  std::string line;
  bool element = false;
  int continued = 0;
  while (std::getline(deck, line)) {
    if (line[0] == '*') element = line.rfind("*ELEMENT, TYPE=C3D20,", 0) == 0;
    EXPECT_LE(std::count(line.begin(), line.end(), ','), 16) << line;
    EXPECT_LE(line.size(), 132u) << line;
    if (element && line.back() == ',') ++continued;
  }
  EXPECT_EQ(continued, 6) << "one a brick";
}

TEST_F(CalculixDeckWriter, WhatNoDeckHoldsIsRefused) {
  const auto refused = [&](const std::function<void(FiniteElementModel&)>& spoil, const std::string& word) {
    FiniteElementModel model = block("C3D8");
    spoil(model);
    expect_error<SceneError>([&] { write_calculix_deck(path_, model); }, {word});
    EXPECT_FALSE(std::filesystem::exists(path_));
  };
  refused([](auto& m) { m.elements.clear(); }, "no elements");
  refused([](auto& m) { m.elements[0].type = "S4"; }, "'S4'");
  refused([](auto& m) { m.elements[0].material = {}; }, "no material");
  refused([](auto& m) { m.node_sets["left, right"] = {1}; }, "left, right");
  expect_error<FileError>([] { write_calculix_deck("/proc/nowhere/deck.inp", block("C3D8")); }, {"/proc/nowhere"});
}

}  // namespace
}  // namespace lithe::test::calculix_deck_writer_test
