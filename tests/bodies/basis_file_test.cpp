// Reduced bodies on disk: what is read is what was written, bit by bit, or an error.
#include <filesystem>
#include <random>

#include "bodies/beam/beam_model.h"
#include "bodies/flexible/basis_file.h"
#include "bodies/flexible/flexible_body.h"
#include "engine/output/hdf5_file.h"
#include "tests/bodies/bar_model.h"
#include "tests/bodies/fe_models.h"

namespace lithe::test::basis_file_test {
namespace {

namespace fs = std::filesystem;

/// In a folder of this test's own: tests run side by side.
std::string path_of(const std::string& name) {
  const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
  const fs::path folder = fs::path(testing::TempDir()) / ("lithe_basis_file_" + test);
  fs::create_directories(folder);
  return (folder / name).string();
}

/// Equal to the last bit.
void expect_same(const MatrixX& a, const MatrixX& b, const char* what) {
  ASSERT_EQ(a.rows(), b.rows()) << what;
  ASSERT_EQ(a.cols(), b.cols()) << what;
  EXPECT_TRUE(a.size() == 0 || std::memcmp(a.data(), b.data(), sizeof(double) * a.size()) == 0) << what;
}

void expect_same(const InertiaIntegrals& a, const InertiaIntegrals& b) {
  EXPECT_EQ(a.mass, b.mass);
  expect_same(MatrixX(a.s0), MatrixX(b.s0), "s0");
  expect_same(MatrixX(a.J0), MatrixX(b.J0), "J0");
  expect_same(MatrixX(a.Ct), MatrixX(b.Ct), "Ct");
  expect_same(MatrixX(a.J1), MatrixX(b.J1), "J1");
  expect_same(a.J2, b.J2, "J2");
  expect_same(MatrixX(a.C0), MatrixX(b.C0), "C0");
  expect_same(a.C1, b.C1, "C1");
  expect_same(a.Mff, b.Mff, "Mff");
  EXPECT_EQ(a.antisymmetric, b.antisymmetric);
}

void expect_same(const ModalBasis& a, const ModalBasis& b) {
  EXPECT_EQ(a.name, b.name);
  expect_same(MatrixX(a.origin), MatrixX(b.origin), "origin");
  expect_same(MatrixX(a.rotation), MatrixX(b.rotation), "rotation");
  EXPECT_EQ(a.node_ids, b.node_ids);
  EXPECT_EQ(a.node_sets, b.node_sets);
  ASSERT_EQ(a.elements.size(), b.elements.size());
  for (size_t k = 0; k < a.elements.size(); ++k) {
    EXPECT_EQ(a.elements[k].type, b.elements[k].type);
    EXPECT_EQ(a.elements[k].nodes, b.elements[k].nodes);
    EXPECT_EQ(a.elements[k].material.young, b.elements[k].material.young);
    EXPECT_EQ(a.elements[k].material.poisson, b.elements[k].material.poisson);
    EXPECT_EQ(a.elements[k].material.density, b.elements[k].material.density);
  }
  expect_same(MatrixX(a.nodes), MatrixX(b.nodes), "nodes");
  ASSERT_EQ(a.rotations.size(), b.rotations.size());
  for (size_t k = 0; k < a.rotations.size(); ++k) {
    EXPECT_EQ(a.rotations[k].node, b.rotations[k].node);
    EXPECT_EQ(a.rotations[k].axis, b.rotations[k].axis);
  }
  expect_same(MatrixX(a.nodal_mass), MatrixX(b.nodal_mass), "nodal mass");
  expect_same(a.modes, b.modes, "modes");
  EXPECT_EQ(a.nodal, b.nodal);
  EXPECT_EQ(a.free_dofs, b.free_dofs);
  expect_same(MatrixX(a.stiffness), MatrixX(b.stiffness), "stiffness");
  expect_same(MatrixX(a.modal_mass), MatrixX(b.modal_mass), "modal mass");
  expect_same(a.damping, b.damping, "damping");
  EXPECT_EQ(a.diagonal, b.diagonal);
  expect_same(a.integrals, b.integrals);
  expect_same(MatrixX(a.frequencies), MatrixX(b.frequencies), "frequencies");
  EXPECT_EQ(a.free_swing_dropped, b.free_swing_dropped);
  ASSERT_EQ(a.deflection == nullptr, b.deflection == nullptr);
  if (!a.deflection) return;
  expect_same(a.deflection->fields, b.deflection->fields, "fields");
  expect_same(a.deflection->curvature, b.deflection->curvature, "curvature");
  expect_same(a.deflection->integrals, b.deflection->integrals);
  expect_same(a.deflection->quartic, b.deflection->quartic, "quartic");
}

/// A basis that has everything a basis may have.
ModalBasis full_basis() {
  FiniteElementModel model = bar_model({.size = {0.3, 0.03, 0.02}, .bricks = {4, 1, 1}});
  model.damping = 1e-5 * model.stiffness;
  model.elements = {{"C3D8I", {{0, 1, 2, 3, 4, 5, 6, 7}, {4, 5, 6, 7, 8, 9, 10, 11}}, {2.07e11, 0.3, 7800}},
                    {"C3D4", {{0, 1, 2, 3}}, {}},
                    {"C3D8", {}, {}}};
  model.node_sets["empty"] = {};
  ModalBasis basis = *make_basis(model, ThreeNodeFrame{1, 17, 2}, 4);
  // Random figures in the parts that make_basis() leaves out here.
  std::mt19937 random(7);
  const auto noise = [&](int rows, int columns) -> MatrixX {
    return MatrixX::NullaryExpr(rows, columns, [&] { return std::normal_distribution<double>()(random); });
  };
  basis.rotations = {{3, 0}, {3, 2}};
  basis.modes = noise(3 * static_cast<int>(basis.nodes.cols()) + 2, 4);
  auto deflection = std::make_shared<QuadraticDeflection>();
  deflection->fields = noise(static_cast<int>(basis.modes.rows()), 3);
  deflection->curvature = noise(7, 10);
  auto& I = deflection->integrals;
  I.mass = 2, I.s0 = noise(3, 1), I.J0 = noise(6, 1), I.Ct = noise(3, 7), I.J1 = noise(6, 7), I.J2 = noise(42, 7);
  I.C0 = noise(3, 7), I.C1 = noise(21, 7), I.Mff = noise(7, 7), I.antisymmetric = false;
  deflection->quartic = noise(10, 10);
  basis.deflection = deflection;
  return basis;
}

TEST(BasisFile, ComesBackBitByBit) {
  const ModalBasis basis = full_basis();
  const std::string path = path_of("full.h5");
  write_modal_basis(basis, path);
  expect_same(*read_modal_basis(path), basis);
  for (const auto& file : fs::directory_iterator(fs::path(path).parent_path()))
    EXPECT_EQ(file.path().string().find("partial"), std::string::npos);
}

TEST(BasisFile, RigidAndNodalBodiesComeBackToo) {
  const FiniteElementModel model = bar_model({.bricks = {2, 1, 1}});
  const BodyFrame frame = TangentFrame{model.node_set("start")};
  for (int count : {0, 3, kAllNodal}) {
    const auto basis = make_basis(model, frame, count);
    const std::string path = path_of("small.h5");
    write_modal_basis(*basis, path);  // over the one before
    const auto read = read_modal_basis(path);
    expect_same(*read, *basis);
    EXPECT_NEAR(FlexibleBody({.basis = read}).mass(), 78, 1e-9);
  }
}

TEST(BasisFile, ABeamComesBackAsThickAsItWas) {
  const Beam beam({.axis = BeamAxis::curved({}, {0.1, 0.5, 0.2}, 1),
                   .sections = {{0, BeamSection::rectangle(0.04, 0.02, {2.1e11, 0.3, 7850})}},
                   .elements = 3});
  const auto basis = make_basis(beam, TangentFrame{{1}}, 4);
  write_modal_basis(*basis, path_of("beam.basis"));
  const auto read = read_modal_basis(path_of("beam.basis"));
  expect_same(*basis, *read);
  ASSERT_TRUE(read->skin);
  expect_same(MatrixX(basis->skin->points), MatrixX(read->skin->points), "points of the skin");
  EXPECT_EQ(basis->skin->nodes, read->skin->nodes);
  EXPECT_EQ(basis->skin->shares, read->skin->shares);
  EXPECT_EQ(basis->skin->triangles, read->skin->triangles);
  EXPECT_EQ(basis->skin->edges, read->skin->edges);
}

TEST(BasisFile, CutAnywhereIsRefused) {
  const std::string path = path_of("cut.h5");
  write_modal_basis(full_basis(), path);
  std::ifstream stream(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(stream)), {});
  for (size_t size = 0; size < bytes.size(); size += 1 + bytes.size() / 61) {
    std::ofstream(path, std::ios::binary) << bytes.substr(0, size);
    EXPECT_THROW(read_modal_basis(path), FileError) << size << " of " << bytes.size();
  }
}

TEST(BasisFile, ADamagedByteIsRefusedOrChangesNothing) {
  const ModalBasis basis = full_basis();
  const std::string path = path_of("damaged.h5");
  write_modal_basis(basis, path);
  std::ifstream stream(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(stream)), {});
  int refused = 0;
  constexpr int kTrials = 300;
  std::mt19937 random(3);
  for (int trial = 0; trial < kTrials; ++trial) {
    std::string damaged = bytes;
    char& byte = damaged[random() % bytes.size()];
    byte = static_cast<char>(byte ^ (1 + random() % 255));
    std::ofstream(path, std::ios::binary) << damaged;
    try {
      expect_same(*read_modal_basis(path), basis);  // padding between data
    } catch (const FileError& error) {
      ++refused;
      EXPECT_FALSE(error.fix().empty());
      EXPECT_EQ(error.where(), path);
    }
  }
  EXPECT_GT(refused, kTrials / 4);
}

TEST(BasisFile, WhatIsNoBasisIsRefusedByName) {
  expect_error<FileError>([] { read_modal_basis(path_of("nowhere.h5")); }, {"no such file"});
  std::ofstream(path_of("text.h5")) << "modes, modes, modes\n";
  expect_error<FileError>([] { read_modal_basis(path_of("text.h5")); }, {"not an HDF5 file"});
  {
    Hdf5Writer file(path_of("other.h5"));
    file.write("/results/time", std::vector<double>{0, 1});
    file.attribute("/", "kind", std::string("something else"));
    file.commit();
  }
  expect_error<FileError>([] { read_modal_basis(path_of("other.h5")); }, {"something else", "lithe modal basis"});
  {
    Hdf5Writer file(path_of("newer.h5"));
    file.attribute("/", "kind", std::string("lithe modal basis"));
    file.attribute("/", "version", 99);
    file.commit();
  }
  expect_error<FileError>([] { read_modal_basis(path_of("newer.h5")); }, {"version 99"});
  expect_error<FileError>([] { write_modal_basis({}, "/proc/nowhere/basis.h5"); }, {"cannot write"});
}

TEST(Hdf5File, WithoutCommitNothingAppears) {
  const std::string path = path_of("uncommitted.h5");
  fs::remove(path);
  {
    Hdf5Writer file(path);
    file.write("/x", MatrixX(MatrixX::Random(3, 2)));
  }
  EXPECT_FALSE(fs::exists(path));
}

TEST(Hdf5File, SizesAndKindsAreChecked) {
  const std::string path = path_of("kinds.h5");
  const MatrixX A = MatrixX::Random(4, 3);
  {
    Hdf5Writer file(path);
    file.write("/a/matrix", A);
    file.write("/a/part", A.block(1, 1, 2, 2));
    file.write("/texts", std::vector<std::string>{"one", "", "three"});
    file.commit();
  }
  const Hdf5Reader file(path);
  expect_same(file.matrix("/a/matrix", 4, 3), A, "matrix");
  expect_same(file.matrix("/a/part"), A.block(1, 1, 2, 2), "part");
  EXPECT_EQ(file.texts("/texts"), (std::vector<std::string>{"one", "", "three"}));
  EXPECT_TRUE(file.has("/a/matrix"));
  EXPECT_FALSE(file.has("/b/matrix"));
  expect_error<FileError>([&] { file.matrix("/a/matrix", 4, 4); }, {"4 x 3 instead of 4 x 4", "/a/matrix"});
  expect_error<FileError>([&] { file.integers("/a/matrix"); }, {"another kind"});
  expect_error<FileError>([&] { file.matrix("/b"); }, {"missing"});
}

}  // namespace
}  // namespace lithe::test::basis_file_test
