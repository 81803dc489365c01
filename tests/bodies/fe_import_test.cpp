#include <filesystem>

#include "bodies/flexible/elements/solid_element.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/readers/calculix_modes.h"
#include "bodies/flexible/readers/gmsh.h"
#include "bodies/flexible/readers/read_flexible_body.h"
#include "bodies/flexible/readers/sid.h"
#include "bodies/flexible/readers/unit_system.h"
#include "tests/bodies/fe_models.h"

namespace lithe::test::fe_import_test {
namespace {

using test::expect_error;
using test::pendulum_path;

constexpr Material kSteel{2.1e11, 0.3, 7850};

std::string import_data(const std::string& file) { return std::string(LITHE_TEST_DATA) + "/import/" + file; }

/// A folder of its own for each test.
class Import : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = ::testing::TempDir() + "lithe_import_" + test->name() + "/";
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& file) const { return folder_ + file; }
  static std::string text_of(const std::string& file) {
    std::ifstream stream(file, std::ios::binary);
    EXPECT_TRUE(stream) << file;
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  void write(const std::string& file, const std::string& text) const {
    std::ofstream(path(file), std::ios::binary) << text;
  }
  /// Lithe's tables of a model, in units of which one is `units` in SI.
  void write_tables(const FiniteElementModel& model, const UnitSystem& units) const {
    const auto market = [&](const std::string& file, const SparseMatrix& A, double unit) {
      const SparseMatrix lower = A.triangularView<Eigen::Lower>();
      std::ofstream out(path(file));
      out.precision(17);
      out << "%%MatrixMarket matrix coordinate real symmetric\n"
          << A.rows() << ' ' << A.cols() << ' ' << lower.nonZeros() << '\n';
      for (int j = 0; j < lower.outerSize(); ++j)
        for (SparseMatrix::InnerIterator e(lower, j); e; ++e)
          out << e.row() + 1 << ' ' << j + 1 << ' ' << e.value() / unit << '\n';
    };
    market("K.mtx", model.stiffness, units.mass / (units.time * units.time));
    market("M.mtx", model.mass, units.mass);
    std::ofstream nodes(path("nodes.csv"));
    nodes.precision(17);
    nodes << "node,x,y,z\n";
    for (int i = 0; i < model.node_count(); ++i) {
      const Vector3 r = model.nodes.col(i) / units.length;
      nodes << model.node_ids[static_cast<size_t>(i)] << ',' << r[0] << ',' << r[1] << ',' << r[2] << '\n';
    }
  }
  /// One file of the fuzz corpus: "=== name" and its text, as job.name.
  void unpack(const std::string& corpus) const {
    std::ifstream stream(import_data("corpus/" + corpus));
    std::ofstream out;
    for (std::string line; std::getline(stream, line);)
      if (line.rfind("=== ", 0) == 0) {
        out.close();
        out.open(path("job." + line.substr(4)), std::ios::binary);
      } else {
        out << line << '\n';
      }
  }

 private:
  std::string folder_;
};

double relative_difference(const VectorX& a, const VectorX& b) {
  EXPECT_EQ(a.size(), b.size());
  return a.size() == b.size() ? (a - b).cwiseAbs().cwiseQuotient(b.cwiseAbs()).maxCoeff() : 1.0;
}

TEST_F(Import, OneBodyThroughThreeFormatsHasTheSameFreeFrequencies) {
  const auto tables = read_flexible_body(pendulum_path("hex8i", "K.mtx"));
  const auto calculix = read_flexible_body(pendulum_path("hex8i", "calculix/matrices.sti"));
  EXPECT_EQ(tables.format, "Matrix Market");
  EXPECT_EQ(calculix.format, "CalculiX matrices");
  EXPECT_EQ(calculix.files.size(), 4u);
  ASSERT_EQ(tables.frequencies.size(), 10);
  EXPECT_GT(tables.frequencies[0], 20);
  EXPECT_LT(relative_difference(tables.frequencies, calculix.frequencies), 1e-9);

  // Free-free modes are those of the free body, so the reduced one has them too.
  write_sid(path("rod.SID_FEM"), *make_basis(*tables.model, MeanAxisFrame{}, 10));
  const auto sid = read_flexible_body(path("rod.SID_FEM"));
  EXPECT_EQ(sid.format, "SID");
  EXPECT_FALSE(sid.model);
  EXPECT_LT(relative_difference(sid.frequencies, tables.frequencies), 1e-9);
  EXPECT_NEAR(sid.check.mass, 0.26, 1e-12);
  EXPECT_LT((sid.check.inertia - tables.check.inertia).cwiseAbs().maxCoeff(), 1e-12 * tables.check.inertia.norm());
}

TEST_F(Import, OneBodyThroughAllFormatsIsFoundByOneName) {
  const auto reference = read_flexible_body(pendulum_path("hex8i", "K.mtx"));
  const std::string formats = std::string(LITHE_TEST_DATA) + "/formats/";
  write("rod.inp", text_of(pendulum_path("hex8i", "calculix/matrices.inp")));
  for (const char* kind : {"coordinate", "labels"}) {
    write("rod_STIF1.mtx", text_of(formats + "abaqus/" + kind + "_STIF1.mtx"));
    write("rod_MASS1.mtx", text_of(formats + "abaqus/" + kind + "_MASS1.mtx"));
    const auto body = read_flexible_body(path("rod.inp"));
    EXPECT_EQ(body.format, "Abaqus");
    EXPECT_LT(relative_difference(body.frequencies, reference.frequencies), 1e-9) << kind;
  }
  for (const char* file :
       {"ansys/stiffness.matrix", "ansys/mass.mmf", "nastran/pendulum_text.op4", "nastran/pendulum_binary.op4"}) {
    const auto body = read_flexible_body(formats + file);
    EXPECT_EQ(body.format, file[0] == 'a' ? "ANSYS" : "Nastran");
    EXPECT_LT(relative_difference(body.frequencies, reference.frequencies), 1e-9) << file;
  }
  // DMIG has ten digits.
  const auto punched = read_flexible_body(formats + "nastran/pendulum.pch");
  EXPECT_LT(relative_difference(punched.frequencies, reference.frequencies), 1e-5);
}

TEST_F(Import, TheSheetTellsFilesUnitsRowsProofAndFrequencies) {
  const auto body = read_flexible_body(pendulum_path("hex8i", "calculix/matrices"));
  const std::string sheet = body.sheet();
  for (const char* told : {"CalculiX", "matrices.inp", "matrices.dof", "m-kg-s", "density 1.73e+04 kg/m3",
                           "the upper triangle", "144 hidden rows of 16 C3D8I", "162 translations and 0 rotations",
                           "0.26 kg", "rigid motion meets force", "K negative eigenvalues", "24.698", "Hz"})
    EXPECT_NE(sheet.find(told), std::string::npos) << told << " is not in\n" << sheet;
}

TEST_F(Import, AFolderOfTablesIsFoundByItsName) {
  EXPECT_EQ(read_flexible_body(pendulum_path("paper", "")).model->node_count(), 68);
  EXPECT_EQ(read_flexible_body(pendulum_path("paper", "M.mtx")).model->node_count(), 68);
}

TEST_F(Import, MillimetresAndTonnesAreAskedForAndBecomeMetresAndKilograms) {
  const auto body = read_flexible_body(pendulum_path("hex8i", "K.mtx"));
  for (const char* name : {"mm-t-s", "mm-kg-ms", "inch-lbf-s"}) {
    const UnitSystem& units = unit_system(name);
    write_tables(*body.model, units);
    expect_error<FileError>([&] { read_flexible_body(path("K.mtx")); },
                            {"units", "K.mtx", "mm-t-s (N, MPa): density", "wave speed about", "--units"});
    const auto converted = read_flexible_body(path("K.mtx"), {.units = name});
    EXPECT_NEAR(converted.check.mass, 0.26, 1e-12) << name;
    EXPECT_LT((converted.check.center - body.check.center).norm(), 1e-12) << name;
    EXPECT_LT(relative_difference(converted.frequencies, body.frequencies), 1e-9) << name;
  }
  expect_error<SceneError>([&] { read_flexible_body(path("K.mtx"), {.units = "cubits"}); }, {"cubits", "mm-t-s"});
}

TEST_F(Import, ReducedBodiesChangeUnitsWithoutChangingTheirMotion) {
  const auto basis = make_basis(test::pendulum("hex8i"), TangentFrame{{1, 2, 3, 4, 5, 6}}, 5);
  // The same body as numbers in millimetres and tonnes: the inverse conversion.
  const UnitSystem inverse{"", 1e3, 1e-3, 1, ""};
  ModalBasis in_mm = *basis;
  convert_to_si(in_mm, inverse);
  write_sid(path("rod.sid"), in_mm);
  expect_error<FileError>([&] { read_flexible_body(path("rod.sid")); }, {"units", "mm-t-s"});
  const auto body = read_flexible_body(path("rod.sid"), {.units = "mm-t-s"});
  const InertiaIntegrals &I = basis->integrals, &J = body.basis->integrals;
  const auto same = [](const MatrixX& a, const MatrixX& b) {
    EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-13 * b.cwiseAbs().maxCoeff());
  };
  same(J.Ct, I.Ct), same(J.J1, I.J1), same(J.C0, I.C0), same(J.C1, I.C1), same(J.J2, I.J2), same(J.J0, I.J0);
  same(body.basis->modes, basis->modes);
  same(MatrixX(body.basis->stiffness), MatrixX(basis->stiffness));
}

TEST_F(Import, AnSidFileHoldsTheReducedBodyToTheLastDigit) {
  // Clamped at the root: all couplings differ from zero, as they do not in mean axes.
  auto basis = std::make_shared<ModalBasis>(*make_basis(test::pendulum("hex8i"), TangentFrame{{1, 2, 3, 4, 5, 6}}, 6));
  basis->damping = 1e-4 * MatrixX(basis->stiffness);
  write_sid(path("rod.sid"), *basis);
  const SidBody read = read_sid(path("rod.sid"));
  const InertiaIntegrals &I = basis->integrals, &J = read.basis->integrals;
  EXPECT_EQ(J.mass, I.mass);
  EXPECT_EQ(J.s0, I.s0);
  EXPECT_EQ(J.J0, I.J0);
  EXPECT_EQ(J.Ct, I.Ct);
  EXPECT_EQ(J.C0, I.C0);
  EXPECT_EQ(J.J1, I.J1);
  EXPECT_EQ(J.C1, I.C1);
  EXPECT_EQ(J.J2, I.J2);
  EXPECT_TRUE(J.antisymmetric);
  EXPECT_EQ(read.basis->modes, basis->modes);
  EXPECT_EQ(read.basis->nodes, basis->nodes);
  EXPECT_EQ(read.basis->node_ids, basis->node_ids);
  EXPECT_EQ(read.basis->damping, basis->damping);
  EXPECT_EQ(MatrixX(read.basis->stiffness), MatrixX(basis->stiffness));
  EXPECT_TRUE(read.basis->diagonal);
  EXPECT_GT(J.C0.norm(), 1e-3);
  EXPECT_GT(J.C1.norm(), 0.1);

  // And it moves as the body that was written: the same mass matrix and forces in a deformed, spinning state.
  FlexibleBody written({.basis = basis}), again({.basis = read.basis});
  VectorX q(13), v(12);
  q << 0.1, 0.2, 0.3, 0.5, 0.5, -0.5, 0.5, 1e-3, -2e-3, 1e-3, 3e-3, -1e-3, 2e-3;
  v << 1, 2, 3, 4, -5, 6, 0.1, -0.2, 0.3, 0.1, 0.2, -0.1;
  const auto force = [&](const FlexibleBody& body) {
    const auto cache = body.make_cache();
    const BodyState state{.q = q.data(), .v = v.data(), .cache = cache.get()};
    body.evaluate(state, Level::velocity);
    return body.quadratic_velocity_force(state);
  };
  EXPECT_EQ(force(written), force(again));
}

TEST_F(Import, AnSidFileMayOrderItsGyroscopicColumnsByModes) {
  const auto basis = make_basis(test::pendulum("hex8i"), TangentFrame{{1, 2, 3, 4, 5, 6}}, 4);
  write_sid(path("rod.sid"), *basis);
  // Column nm axis + k becomes 3 k + axis.
  std::ifstream by_axes(path("rod.sid"));
  std::ofstream by_modes(path("modes.sid"));
  bool inside = false;
  for (std::string line; std::getline(by_axes, line);) {
    const std::string word = line.substr(std::min(line.find_first_not_of(' '), line.size()));
    if (word == "Gr" || word == "Ge") inside = true;
    if (word == "end Gr" || word == "end Ge") inside = false;
    int row = 0, column = 0;
    if (inside && std::sscanf(word.c_str(), "m0( %d, %d)", &row, &column) == 2)
      line = "m0( " + std::to_string(row) + ", " + std::to_string(3 * ((column - 1) % 4) + (column - 1) / 4 + 1) +
             ") " + line.substr(line.find('='));
    by_modes << line << '\n';
  }
  by_modes.close();
  const SidBody read = read_sid(path("modes.sid"));
  EXPECT_EQ(read.basis->integrals.J1, basis->integrals.J1);
  EXPECT_EQ(read.basis->integrals.C1, basis->integrals.C1);
  EXPECT_EQ(read.notes,
            (std::vector<std::string>{"54 nodes, without rotations (psi)", "columns of Gr and Ge go by modes"}));
}

TEST_F(Import, RotationsOfNodesTravelInAnSidFile) {
  auto basis = std::make_shared<ModalBasis>(*make_basis(test::pendulum("hex8i"), MeanAxisFrame{}, 2));
  const auto n = static_cast<int>(basis->nodes.cols());
  basis->modes.conservativeResize(6 * n, 2);
  for (int i = 0; i < n; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      basis->rotations.push_back({i, axis});
      basis->modes.row(3 * (n + i) + axis) << 0.1 * i - axis, 0.3 * axis;
    }
  write_sid(path("rod.sid"), *basis);
  const SidBody read = read_sid(path("rod.sid"));
  EXPECT_EQ(read.basis->modes, basis->modes);
  EXPECT_EQ(read.basis->rotations.size(), basis->rotations.size());
}

TEST_F(Import, MeshesOfGmshFillTheirBoxInBothVersionsAndAllElements) {
  const struct {
    const char* mesh;
    const char* type;
  } meshes[] = {{"box_0_1", "C3D4"}, {"box_0_2", "C3D10"}, {"box_1_1", "C3D8I"}, {"box_1_2", "C3D20"}};
  for (const auto& [mesh, type] : meshes)
    for (const char* version : {"_22", "_41"}) {
      unpack("gmsh/" + std::string(mesh) + version);
      const FiniteElementModel model = read_gmsh(path("job.msh"), kSteel);
      ASSERT_EQ(model.elements.size(), 1u) << mesh;
      EXPECT_EQ(model.elements[0].type, type);
      double volume = 0;
      for (const SolidElement& element : make_solid_elements(model))
        for (const SolidPoint& point : element.points) volume += point.volume;
      EXPECT_NEAR(volume, 1e-3, 1e-15) << mesh << version;
      // Midside nodes stand between their corners: edge 1-2 first in every order, then the edges that orders differ in.
      for (const auto& e : model.elements[0].nodes) {
        const auto middle = [&](int a, int b, int c) {
          EXPECT_LT((0.5 * (model.nodes.col(e[a]) + model.nodes.col(e[b])) - model.nodes.col(e[c])).norm(), 1e-12)
              << type << " node " << c + 1;
        };
        if (e.size() == 10)
          middle(0, 1, 4), middle(1, 2, 5), middle(2, 0, 6), middle(0, 3, 7), middle(1, 3, 8), middle(2, 3, 9);
        if (e.size() == 20)
          for (int k = 0; k < 4; ++k)
            middle(k, (k + 1) % 4, 8 + k), middle(4 + k, 4 + (k + 1) % 4, 12 + k), middle(k, 4 + k, 16 + k);
      }
      for (int id : model.node_set("root")) EXPECT_NEAR(model.nodes(2, model.node_index(id)), 0, 1e-12);
      EXPECT_GE(model.node_set("Root").size(), 4u);
      EXPECT_EQ(model.node_set("corner").size(), 1u);
      EXPECT_EQ(model.node_set("steel").size(), static_cast<size_t>(model.node_count()));
    }
}

TEST_F(Import, AMeshOfGmshBecomesABodyWithItsMaterial) {
  unpack("gmsh/box_1_2_41");
  const auto body = read_flexible_body(path("job.msh"), {.materials = {{"STEEL", kSteel}}});
  EXPECT_NEAR(body.check.mass, 7.85, 1e-12);
  EXPECT_GT(body.frequencies[0], 1000);
  expect_error<FileError>(
      [&] {
        read_flexible_body(path("job.msh"), {.materials = {{"copper", kSteel}}});
      },
      {"steel", "job.msh:", "material"});
}

TEST_F(Import, ModesOfAFrdFileAreThoseOfItsMatrices) {
  for (const char* extension : {"inp", "sti", "mas", "dof"})
    write("rod." + std::string(extension),
          text_of(pendulum_path("paper", "calculix/matrices." + std::string(extension))));
  write("rod.frd", text_of(import_data("pendulum_paper.frd")));
  const auto body = read_flexible_body(path("rod.frd"));
  ASSERT_EQ(body.modes.cols(), 12);
  const auto imported = read_calculix_modes(path("rod.frd"), *body.model);
  for (int k = 6; k < 12; ++k) {
    const VectorX shape = body.modes.col(k);
    const double mass = shape.dot(body.model->mass * shape);
    const double hertz = std::sqrt(shape.dot(body.model->stiffness * shape) / mass) / (2 * M_PI);
    EXPECT_NEAR(mass, 1, 1e-5);  // six digits are printed
    EXPECT_NEAR(hertz, body.frequencies[k - 6], 1e-5 * hertz);
    EXPECT_NEAR(imported.frequencies[k], hertz, 1e-5 * hertz);
  }
}

TEST_F(Import, UnknownFilesAreRefusedWithWhatIsKnown) {
  write("notes.txt", "a letter\n");
  expect_error<FileError>([&] { read_flexible_body(path("notes.txt")); }, {"'a letter'", "SID", "Matrix Market"});
  expect_error<FileError>([&] { read_flexible_body(path("none.sid")); }, {"no such file", "none.sid"});
  expect_error<FileError>([&] { read_flexible_body(path("")); }, {"folder", "K.mtx"});
}

/// One spoilt file: `from` replaced by `to` (or, with an empty `from`, the file cut to the share `keep`).
struct Spoilt {
  const char* corpus;  // unpacked to job.*
  const char* file;
  const char* from;
  const char* to;
  const char* mentions;
  double keep = 0;
};

TEST_F(Import, SpoiltFilesAreRefusedWithFileLineAndRemedy) {
  const Spoilt all[] = {
      // Standard Input Data
      {"sid/brick", "job.sid", "", "", "job.sid:", 0.3},
      {"sid/brick", "job.sid", "", "", "job.sid:", 0.97},
      {"sid/brick", "job.sid", "end part", "end", "'end part' should stand"},
      {"sid/brick", "job.sid", "nelastq = 2", "nelastq = 3", "nelastq is 3"},
      {"sid/brick", "job.sid", " 8 2 :No", " 9 2 :No", "8 nodes"},
      {"sid/brick", "job.sid", "nrow = 3", "nrow = 4", "not 3 x 1"},
      {"sid/brick", "job.sid", "m0( 1, 1) =", "m0( 4, 1) =", "outside table"},
      {"sid/brick", "job.sid", "m1( 1, 1, 1) =", "m1( 1, 1, 1) = nan", "not a"},
      {"sid/brick", "job.sid", "m1( 1, 1, 1) = ", "m1( 1, 1, 1) = 7", "contradicts"},
      {"sid/brick", "job.sid", "mass = 7", "mass = -7", "the mass is"},
      {"sid/brick", "job.sid", "mdCM", "mdXM", "no table is called"},
      {"sid/brick", "job.sid", "Eigen Mode 1 : 1", "Eigen Mode 1 : 9", "Ke and Me give"},
      {"sid/brick", "job.sid", "new node = 2", "new node = 1", "given twice"},
      // gmsh
      {"gmsh/box_1_2_41", "job.msh", "", "", "job.msh:", 0.4},
      {"gmsh/box_1_2_41", "job.msh", "", "", "job.msh:", 0.9},
      {"gmsh/box_1_2_41", "job.msh", "4.1 0 8", "4.1 1 8", "binary"},
      {"gmsh/box_1_2_41", "job.msh", "4.1 0 8", "3 0 8", "version 3"},
      {"gmsh/box_1_1_22", "job.msh", "0.1", "0.l", "job.msh:"},
      {"gmsh/box_1_1_22", "job.msh", "$Elements\n", "$Elements\n1", "job.msh:"},
      {"gmsh/box_1_1_22", "job.msh", " 5 2 1 1 1 2", " 5 2 1 1 1 99", "node 99"},
      {"gmsh/box_1_1_22", "job.msh", " 5 2 1 1 ", " 5 2 1 1 7 ", "nodes"},
      {"gmsh/box_1_1_22", "job.msh", " 5 2 1 1 ", " 12 2 1 1 ", "type 12"},
      // CalculiX
      {"calculix/tetrahedron", "job.sti", "", "", "job.sti:", 0.5},
      {"calculix/tetrahedron", "job.dof", "", "", "job.dof", 0.5},
      {"calculix/tetrahedron", "job.dof", "2.3", "2.4", "direction 4"},
      {"calculix/tetrahedron", "job.inp", "1, 1, 2, 3, 4", "1, 1, 2, 3, 5", "node 5"},
      {"calculix/tetrahedron", "job.mas", "e-", "ee", "job.mas:"},
      // Matrix Market
      {"matrix_market/tetrahedron", "job.K", "12 12 78", "12 12 79", "job.K"},
      {"matrix_market/tetrahedron", "job.M", "", "", "job.M", 0.6},
      {"matrix_market/tetrahedron", "job.nodes", "2,0.1", "1,0.1", "given twice"},
      {"matrix_market/tetrahedron", "job.sets", "tip,1,4", "tip,1,9", "node 9"},
      // mode shapes
      {"frd/tetrahedron", "job.frd", "", "", "job.frd:", 0.5},
      {"frd/tetrahedron", "job.frd", "1MODAL      1", "1MODAL      2", "format '2'"},
      {"frd/tetrahedron", "job.frd", " 9999", "", "9999"},
  };
  FiniteElementModel four;
  four.node_ids = {1, 2, 3, 4};
  four.nodes = Matrix3X::Zero(3, 4);
  int refused = 0;
  for (const Spoilt& spoilt : all) {
    SCOPED_TRACE(std::string(spoilt.file) + ": " + spoilt.from + " -> " + spoilt.to + " " + spoilt.mentions);
    unpack(spoilt.corpus);
    std::string text = text_of(path(spoilt.file));
    if (spoilt.from[0] == '\0') {
      text.resize(static_cast<size_t>(spoilt.keep * static_cast<double>(text.size())));
    } else {
      const size_t at = text.find(spoilt.from);
      ASSERT_NE(at, std::string::npos);
      text.replace(at, std::string(spoilt.from).size(), spoilt.to);
    }
    write(spoilt.file, text);
    const std::string format = std::string(spoilt.corpus).substr(0, std::string(spoilt.corpus).find('/'));
    expect_error<FileError>(
        [&] {
          if (format == "sid") read_sid(path("job.sid"));
          if (format == "gmsh") read_gmsh(path("job.msh"), kSteel);
          if (format == "calculix") read_calculix(path("job"));
          if (format == "matrix_market")
            read_matrix_market(path("job.K"), path("job.M"), path("job.nodes"), path("job.sets"), path("job.elements"));
          if (format == "frd") read_calculix_modes(path("job.frd"), four);
        },
        {spoilt.mentions, spoilt.file});
    ++refused;
  }
  EXPECT_GE(refused, 30);
}

}  // namespace
}  // namespace lithe::test::fe_import_test
