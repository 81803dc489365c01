#include <Eigen/LU>
#include <algorithm>
#include <set>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/elements/stress_recovery.h"
#include "bodies/flexible/readers/calculix_deck.h"
#include "bodies/flexible/readers/gmsh.h"
#include "bodies/flexible/reduction.h"
#include "tests/bodies/fe_models.h"
#include "tests/support/linear_algebra.h"

namespace lithe::test::solid_elements_test {
namespace {

const Material kAluminium{7e10, 0.33, 2700};
const std::vector<std::string> kTypes{"C3D4", "C3D8", "C3D8I", "C3D10", "C3D20", "C3D20R"};

std::string data(const std::string& file) { return std::string(LITHE_TEST_DATA) + "/" + file; }

std::vector<int> dofs_of(const FiniteElementModel& model, const std::string& set) {
  std::vector<int> dofs;
  for (int id : model.node_set(set))
    for (int axis = 0; axis < 3; ++axis) dofs.push_back(3 * model.node_index(id) + axis);
  return dofs;
}

/// Moves nodes so that elements keep straight edges and flat or bilinear faces, but no two have the same shape.
void distort(FiniteElementModel& model, const std::function<Vector3(const Vector3&)>& move) {
  const Matrix3X old = model.nodes;
  std::set<int> corners;
  for (const ElementBlock& block : model.elements)
    for (const auto& nodes : block.nodes)
      corners.insert(nodes.begin(), nodes.begin() + (nodes.size() == 4 || nodes.size() == 10 ? 4 : 8));
  for (int i : corners) model.nodes.col(i) = move(old.col(i));
  // The middle of an edge of the old mesh stays the middle of the new edge.
  for (const ElementBlock& block : model.elements)
    for (const auto& nodes : block.nodes) {
      const size_t count = nodes.size() == 10 ? 4 : 8;
      for (size_t m = count; m < nodes.size(); ++m)
        for (size_t a = 0; a < count; ++a)
          for (size_t b = 0; b < a; ++b)
            if ((old.col(nodes[a]) + old.col(nodes[b]) - 2 * old.col(nodes[m])).norm() < 1e-12 &&
                (nodes.size() == 10 || ((old.col(nodes[a]) - old.col(nodes[b])).array().abs() > 1e-12).count() == 1))
              model.nodes.col(nodes[m]) = 0.5 * (model.nodes.col(nodes[a]) + model.nodes.col(nodes[b]));
    }
  assemble_matrices(model);
}

TEST(SolidElements, TheMatricesOfThePendulumAreThoseOfCalculiX) {
  for (const auto& [body, young, poisson] :
       {std::tuple{"hex8i", 1e7, 0.49}, {"hex20", 1e7, 0.49}, {"paper", 1e7, 0.49}, {"stiff", 2e11, 0.3}}) {
    const FiniteElementModel exported = test::pendulum(body);
    FiniteElementModel own = exported;
    for (ElementBlock& block : own.elements) {
      block.material = {young, poisson, 0.26 / (0.1 * 0.01 * 0.015)};
      if (body != std::string("paper") && block.type == "C3D8") block.type = "C3D8I";
    }
    assemble_matrices(own);
    EXPECT_LT(test::difference(own.stiffness, exported.stiffness), 1e-12) << body;
    EXPECT_LT(test::difference(own.mass, exported.mass), 1e-12) << body;
  }
}

TEST(SolidElements, ADeckAloneGivesTheMatricesThatCalculiXExports) {
  for (const char* body : {"hex8i", "hex20", "stiff"}) {
    const FiniteElementModel own = read_calculix_mesh(test::pendulum_path(body, "calculix/matrices.inp"));
    const FiniteElementModel exported = test::pendulum_from_calculix(body);
    EXPECT_EQ(own.node_ids, exported.node_ids);
    EXPECT_EQ(own.node_sets, exported.node_sets);
    EXPECT_LT(test::difference(own.stiffness, exported.stiffness), 1e-11) << body;
    EXPECT_LT(test::difference(own.mass, exported.mass), 1e-11) << body;
    EXPECT_GT(exported.elements.at(0).material.young, 0) << "read_calculix() gives stress recovery its material";
  }
}

TEST(SolidElements, ConstantStrainPassesThroughDistortedMeshes) {
  Matrix3 gradient;
  gradient << 1e-3, 2e-4, -3e-4, 5e-4, -4e-4, 1e-4, 2e-4, 6e-4, 7e-4;
  for (const std::string& type : kTypes) {
    FiniteElementModel model =
        brick_mesh({.size = {0.3, 0.2, 0.2}, .divisions = {3, 2, 2}, .type = type, .material = kAluminium});
    distort(model, [&](const Vector3& r) {
      // With reduced integration only parallelepipeds pass: its points do not integrate ∇N of other bricks exactly.
      if (type == "C3D20R") return Vector3(r[0] + 0.2 * r[1], r[1] - 0.1 * r[2], r[2] + 0.3 * r[0]);
      return Vector3(r + 0.015 * Vector3(std::sin(40 * r[1] + 9 * r[2]), std::cos(30 * r[0]), std::sin(25 * r[0] + 1)));
    });
    const VectorX u = (gradient * model.nodes).reshaped();
    const VectorX force = model.stiffness * u;
    std::set<int> boundary;
    for (const char* face : {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"})
      for (int id : model.node_set(face)) boundary.insert(model.node_index(id));
    double inside = 0;
    ASSERT_LT(static_cast<int>(boundary.size()), model.node_count());
    for (int i = 0; i < model.node_count(); ++i)
      if (!boundary.count(i)) inside = std::max(inside, force.segment<3>(3 * i).cwiseAbs().maxCoeff());
    EXPECT_LT(inside, 1e-12 * force.cwiseAbs().maxCoeff()) << type;

    const Matrix3 strain = 0.5 * (gradient + gradient.transpose());
    const Matrix3 stress =
        2 * 7e10 / (2 * 1.33) * strain + 7e10 * 0.33 / (1.33 * 0.34) * strain.trace() * Matrix3::Identity();
    Vector6 wanted;
    wanted << stress(0, 0), stress(1, 1), stress(2, 2), stress(0, 1), stress(0, 2), stress(1, 2);
    const Matrix6X found = StressRecovery(model, u).stress(VectorX::Ones(1));
    EXPECT_LT((found.colwise() - wanted).cwiseAbs().maxCoeff(), 1e-10 * wanted.cwiseAbs().maxCoeff()) << type;
  }
}

TEST(SolidElements, ABodyTurnsAndMovesWithoutStress) {
  const Matrix3 turn = rotation_exp({0.4, -0.7, 0.2});
  for (const std::string& type : kTypes) {
    FiniteElementModel model =
        brick_mesh({.size = {0.3, 0.2, 0.2}, .divisions = {2, 1, 1}, .type = type, .material = kAluminium});
    distort(model, [](const Vector3& r) { return Vector3(r + 0.02 * Vector3(std::sin(9 * r[1]), r[0], r[2] * r[1])); });
    const MatrixX rigid = rigid_motions(model.nodes, Vector3(0.1, 0, 0));
    EXPECT_LT((model.stiffness * rigid).cwiseAbs().maxCoeff(), 1e-12 * test::largest(model.stiffness)) << type;
    const StressRecovery small(model, rigid);
    EXPECT_LT(small.stress(VectorX::LinSpaced(6, 1, 2)).cwiseAbs().maxCoeff(), 1e-11 * 7e10) << type;
    // Finite turns: Green's strain sees none of them, small strain takes them for 1 - cos.
    const VectorX turned = (turn * model.nodes - model.nodes).reshaped();
    EXPECT_LT(
        StressRecovery(model, turned, StrainMeasure::green_lagrange).stress(VectorX::Ones(1)).cwiseAbs().maxCoeff(),
        1e-9 * 7e10)
        << type;
    EXPECT_GT(StressRecovery(model, turned).stress(VectorX::Ones(1)).cwiseAbs().maxCoeff(), 0.1 * 7e10) << type;
  }
}

TEST(SolidElements, ACantileverBendsAsTimoshenkoSays) {
  const double length = 1, side = 0.1, load = 100, young = 2e11, poisson = 0.3;
  const double inertia = std::pow(side, 4) / 12, shear = young / (2 * (1 + poisson));
  const double theory =
      load * std::pow(length, 3) / (3 * young * inertia) +
      load * length / (10 * (1 + poisson) / (12 + 11 * poisson) * shear * side * side);  // Cowper 1966
  for (const auto& [type, least, most] : {std::tuple{"C3D20", 0.99, 1.001},
                                          {"C3D20R", 0.99, 1.005},
                                          {"C3D8I", 0.99, 1.001},
                                          {"C3D10", 0.98, 1.001},
                                          {"C3D8", 0.5, 0.95}}) {
    const FiniteElementModel model = brick_mesh(
        {.size = {length, side, side}, .divisions = {10, 2, 2}, .type = type, .material = {young, poisson, 7800}});
    const std::vector<int> tip = dofs_of(model, "x_max");
    // Held as the beam's end: no axial displacement, but free to change its width.
    SparseMatrix K = model.stiffness;
    for (int id : model.node_set("x_min")) {
      const int i = model.node_index(id);
      const double hold = 1e6 * test::largest(model.stiffness);
      K.coeffRef(3 * i, 3 * i) += hold;
      for (int axis : {1, 2})
        if (std::abs(model.nodes(axis, i) - side / 2) < 1e-12) K.coeffRef(3 * i + axis, 3 * i + axis) += hold;
    }
    VectorX force = VectorX::Zero(model.dof_count());
    for (size_t k = 2; k < tip.size(); k += 3) force[tip[k]] = load / (static_cast<double>(tip.size()) / 3);
    const VectorX u = test::solve_sparse(K, force);
    double deflection = 0;
    for (size_t k = 2; k < tip.size(); k += 3) deflection += u[tip[k]] / (static_cast<double>(tip.size()) / 3);
    std::printf("%s: %.4f of the beam's deflection\n", type, deflection / theory);
    EXPECT_GT(deflection, least * theory) << type;
    EXPECT_LT(deflection, most * theory) << type;
  }
}

TEST(Meshes, TheOwnMeshOfThePendulumHasItsFrequencies) {
  const FiniteElementModel model = brick_mesh({.size = {0.1, 0.01, 0.015},
                                               .divisions = {8, 2, 1},
                                               .type = "C3D20",
                                               .material = {1e7, 0.49, 0.26 / (0.1 * 0.01 * 0.015)}});
  const auto reference = test::csv_columns(test::pendulum_path("hex20", "frequencies.csv"));
  for (const char* support : {"free", "clamped"}) {
    const bool clamped = support == std::string("clamped");
    const auto& wanted = reference.at(support);
    const VectorX found =
        frequencies(model, clamped ? dofs_of(model, "x_min") : std::vector<int>{}, static_cast<int>(wanted.size()));
    for (size_t k = clamped ? 0 : 6; k < wanted.size(); ++k) {
      // K.mtx has the 14 digits that CalculiX prints: their round-off, 35 times ours by the force on rigid motions,
      // is felt by the lowest clamped mode.
      const double bound = clamped && k == 0 ? 5e-8 : 1e-9;
      EXPECT_NEAR(found[static_cast<Eigen::Index>(k)] / wanted[k], 1, bound) << support << " " << k;
    }
  }
}

TEST(Meshes, FrequenciesAreInverseToTheSize) {
  const auto of_size = [](double size) {
    const FiniteElementModel brick = brick_mesh(
        {.size = size * Vector3(3, 1, 0.7), .divisions = {5, 2, 1}, .type = "C3D20", .material = {2e11, 0.3, 7800}});
    return VectorX(size * frequencies(brick, {}, 20));
  };
  const VectorX large = of_size(1), small = of_size(1e-5);  // to 30 micrometres, above 100 MHz
  EXPECT_LT((small - large).cwiseAbs().maxCoeff(), 1e-9 * large.maxCoeff());
}

TEST(Meshes, BricksPlatesAndRodsHaveTheirMassAndInertia) {
  for (const std::string& type : kTypes) {
    const ModelCheck brick = require_sound(
        brick_mesh({.size = {0.3, 0.2, 0.1}, .divisions = {3, 2, 1}, .type = type, .material = kAluminium}));
    EXPECT_NEAR(brick.mass, 2700 * 0.006, 1e-12 * brick.mass) << type;
    EXPECT_LT((brick.center - Vector3(0.15, 0.1, 0.05)).norm(), 1e-14) << type;
    const Vector3 wanted = brick.mass / 12 * Vector3(0.05, 0.1, 0.13);
    EXPECT_LT((brick.inertia - Matrix3(wanted.asDiagonal())).cwiseAbs().maxCoeff(), 1e-12) << type;
  }
  const ModelCheck plate = require_sound(
      plate_mesh({.length = 0.4, .width = 0.3, .thickness = 0.002, .divisions = {4, 3}, .material = kAluminium}));
  EXPECT_NEAR(plate.mass, 2700 * 0.4 * 0.3 * 0.002, 1e-12);
  EXPECT_NEAR(plate.center[2], 0, 1e-15);

  const FiniteElementModel rod =
      rod_mesh({.length = 0.5, .radius = 0.02, .along = 6, .across = 6, .material = kAluminium});
  const ModelCheck round = require_sound(rod);
  const double mass = 2700 * 0.5 * std::numbers::pi * 4e-4;
  EXPECT_NEAR(round.mass, mass, 1e-3 * mass);
  EXPECT_NEAR(round.inertia(0, 0), mass * 4e-4 / 2, 2e-3 * mass * 4e-4);
  EXPECT_NEAR(round.inertia(1, 1), round.inertia(2, 2), 1e-12);
  for (int id : rod.node_set("surface")) EXPECT_NEAR(rod.nodes.col(rod.node_index(id)).tail<2>().norm(), 0.02, 1e-15);
  EXPECT_EQ(rod.node_set("axis").size(), 13u);
  // A round section twists at sqrt(G / density) / 2 L: the mesh must be round in stiffness, too.
  const VectorX hertz = frequencies(rod, {}, 20);
  const double twist = std::sqrt(7e10 / (2 * 1.33) / 2700) / (2 * 0.5);
  double nearest = 1;
  for (double f : hertz) nearest = std::min(nearest, std::abs(f / twist - 1));
  EXPECT_LT(nearest, 2e-3);
}

TEST(Meshes, NodesAreNumberedFromTheOriginAndFacesAreSets) {
  for (const std::string& type : kTypes) {
    const FiniteElementModel model =
        brick_mesh({.size = {0.3, 0.2, 0.1}, .divisions = {3, 2, 1}, .type = type, .material = kAluminium});
    EXPECT_EQ(model.nodes.col(0), Vector3::Zero()) << type;
    EXPECT_LT((model.nodes.col(model.node_count() - 1) - Vector3(0.3, 0.2, 0.1)).norm(), 1e-15) << type;
    EXPECT_EQ(model.node_set("all").size(), static_cast<size_t>(model.node_count()));
    for (int id : model.node_set("y_max")) EXPECT_NEAR(model.nodes(1, model.node_index(id)), 0.2, 1e-15);
    const size_t faces[] = {6, 6, 6, 15, 13, 13};  // nodes of x_min: 2 x 1 cells
    EXPECT_EQ(model.node_set("x_min").size(),
              faces[static_cast<size_t>(std::find(kTypes.begin(), kTypes.end(), type) - kTypes.begin())]);
  }
}

TEST(Meshes, TheBracketOfGmshHasTheEigenvaluesOfCalculiX) {
  FiniteElementModel model = read_gmsh(data("bracket/bracket.msh"), kAluminium);
  assemble_matrices(model, MassIntegration::stiffness_points);  // as CalculiX; exact: 1e-4 in the eigenvalues
  ASSERT_GE(model.dof_count(), 20000);
  std::ifstream stream(data("bracket/frequencies.csv"));
  std::map<std::string, std::vector<double>> wanted;  // eigenvalues, seven digits
  std::string line, cell;
  for (std::getline(stream, line); std::getline(stream, line);) {
    std::istringstream row(line);
    std::string support;
    std::getline(row, support, ',');
    std::getline(row, cell, ',');
    std::getline(row, cell, ',');
    wanted[support].push_back(std::stod(cell));
  }
  ASSERT_EQ(wanted.size(), 2u);
  for (const auto& [support, eigenvalues] : wanted) {
    const bool clamped = support == "clamped";
    const VectorX hertz =
        frequencies(model, clamped ? dofs_of(model, "back") : std::vector<int>{}, static_cast<int>(eigenvalues.size()));
    double worst = 0;
    for (size_t k = clamped ? 0 : 6; k < eigenvalues.size(); ++k) {
      const double omega = 2 * std::numbers::pi * hertz[static_cast<Eigen::Index>(k)];
      worst = std::max(worst, std::abs(omega * omega / eigenvalues[k] - 1));
    }
    std::printf("bracket, %s: eigenvalues within %.1e of CalculiX's\n", support.c_str(), worst);
    EXPECT_LT(worst, 1e-6) << support;
  }
}

TEST(SolidElements, WhatIsNoElementIsRefusedByName) {
  const FiniteElementModel good = brick_mesh({.type = "C3D8", .material = kAluminium, .name = "crate"});
  const auto broken = [&](const std::function<void(FiniteElementModel&)>& spoil,
                          const std::vector<std::string>& words) {
    FiniteElementModel model = good;
    spoil(model);
    test::expect_error<SceneError>([&] { assemble_matrices(model); }, words);
  };
  broken(
      [](auto& m) {
        std::swap_ranges(&m.elements[0].nodes[0][0], &m.elements[0].nodes[0][4], &m.elements[0].nodes[0][4]);
      },
      {"inside out", "crate", "C3D8", "nodes"});
  broken([](auto& m) { m.nodes.row(2).setZero(); }, {"no volume", "crate"});
  broken([](auto& m) { m.nodes(0, 3) = std::nan(""); }, {"not a number", "crate"});
  broken([](auto& m) { m.elements[0].nodes[0].pop_back(); }, {"7 nodes", "give 8"});
  broken([](auto& m) { m.elements[0].nodes[0][0] = 8; }, {"node index 8"});
  broken([](auto& m) { m.elements[0].type = "C3D6"; }, {"C3D6", "C3D20R"});
  broken([](auto& m) { m.elements[0].material.young = 0; }, {"Young"});
  broken([](auto& m) { m.elements[0].material.poisson = 0.5; }, {"Poisson"});
  broken([](auto& m) { m.elements[0].material.density = -1; }, {"density"});
  broken([](auto& m) { m.elements.clear(); }, {"no elements"});
  const auto refused = [](const std::function<void()>& call, const std::vector<std::string>& words) {
    test::expect_error<SceneError>(call, words);
  };
  refused([] { brick_mesh({.size = {1, 0, 1}, .material = kAluminium}); }, {"size"});
  refused([] { brick_mesh({.divisions = {1, 0, 1}, .material = kAluminium}); }, {"0 cells along y"});
  refused([] { brick_mesh({.divisions = {9999, 9999, 9999}, .material = kAluminium}); }, {"two million"});
  refused([] { brick_mesh({.type = "BRICK", .material = kAluminium}); }, {"BRICK", "known are"});
  refused([] { brick_mesh({}); }, {"density"});
  refused([] { rod_mesh({.across = 1, .material = kAluminium}); }, {"across"});
  refused([] { plate_mesh({.thickness = -1, .material = kAluminium}); }, {"thickness"});
}

TEST(CalculixDeck, BlocksAreSplitByTypeAndMaterial) {
  const std::string path = testing::TempDir() + "materials.inp";
  std::ofstream(path)
      << "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n"
         "*ELEMENT, TYPE=C3D4, ELSET=Soft\n1,1,2,3,4\n2,2,3,4,5\n"
         "*ELEMENT, TYPE=C3D4\n3,1,2,3,4\n4,1,2,3,4\n5,1,2,3,4\n6,1,2,3,4\n"
         "*ELSET, ELSET=HARD\n3,\n*ELSET, ELSET=both, GENERATE\n3,4\n*elset, elset=WOOD\n5\n"
         "*SOLID SECTION, MATERIAL=Steel, ELSET=BOTH\n*SOLID SECTION, ELSET=SOFT, MATERIAL=RUBBER\n"
         "*Solid Section, elset=wood, material=oak\n"
         "*MATERIAL, NAME=RUBBER\n*ELASTIC\n1e7, 0.49\n*DENSITY\n1100\n"
         "*MATERIAL, NAME=STEEL\n*DENSITY\n7800.\n*ELASTIC, TYPE=ISO\n2.1e11, 0.3, 293.\n"
         "*MATERIAL, NAME=OAK\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n1e10,1e9,1e9,.3,.3,.3,1e9,1e9\n1e9\n";
  const CalculixDeck deck = read_calculix_deck(path);
  ASSERT_EQ(deck.elements.size(), 4u);
  EXPECT_EQ(deck.elements[0].material.young, 1e7);
  EXPECT_EQ(deck.elements[0].material.density, 1100);
  EXPECT_EQ(deck.elements[0].nodes.size(), 2u);
  EXPECT_EQ(deck.elements[1].material.young, 2.1e11);
  EXPECT_EQ(deck.elements[1].material.poisson, 0.3);
  EXPECT_EQ(deck.elements[1].nodes.size(), 2u);
  EXPECT_EQ(deck.elements[2].material.young, 0) << "not isotropic";
  EXPECT_EQ(deck.elements[3].material.young, 0) << "no section";
  test::expect_error<SceneError>([&] { read_calculix_mesh(path); }, {"density", "materials.inp"});

  std::ofstream(path) << "*NODE\n1,0,0,0\n*MATERIAL,NAME=A\n*ELASTIC\n1e7, soft\n";
  test::expect_error<FileError>([&] { read_calculix_deck(path); }, {"materials.inp:5", "Poisson"});
}

}  // namespace
}  // namespace lithe::test::solid_elements_test
