#include <filesystem>

#include "bodies/flexible/readers/abaqus.h"
#include "bodies/flexible/readers/ansys.h"
#include "bodies/flexible/readers/dof_table.h"
#include "bodies/flexible/readers/harwell_boeing.h"
#include "bodies/flexible/readers/nastran.h"
#include "bodies/flexible/readers/nastran_deck.h"
#include "bodies/flexible/readers/nastran_op4.h"
#include "bodies/flexible/reduction.h"
#include "tests/bodies/fe_models.h"

namespace lithe::test::fe_formats_test {
namespace {

using test::difference;
using test::expect_error;
using test::pendulum;
using test::pendulum_path;

std::string text_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  EXPECT_TRUE(stream) << path;
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// One body in one format: its files, and how they are read from a folder.
struct Format {
  const char* name;
  std::vector<std::string> files;  // below tests/data/formats
  FiniteElementModel (*read)(const std::string& folder);
  double matrix_bound, frequency_bound;  // what the digits of the format leave
  bool has_elements;
};

const std::vector<Format>& formats() {
  static const std::vector<Format> all = {
      {"ansys, Harwell-Boeing",
       {"ansys/stiffness.matrix", "ansys/mass.matrix", "ansys/pendulum.mapping", "ansys/nodes.cdb"},
       [](const std::string& f) {
         return read_ansys({f + "stiffness.matrix", f + "mass.matrix", f + "pendulum.mapping", f + "nodes.cdb"});
       },
       5e-15,
       1e-9,
       true},
      {"ansys, Matrix Market",
       {"ansys/stiffness.mmf", "ansys/mass.mmf", "ansys/mapping.mmf", "ansys/nodes.node"},
       [](const std::string& f) {
         return read_ansys({f + "stiffness.mmf", f + "mass.mmf", f + "mapping.mmf", f + "nodes.node"});
       },
       5e-16,
       1e-9,
       false},
      {"abaqus, coordinate",
       {"abaqus/coordinate_STIF1.mtx", "abaqus/coordinate_MASS1.mtx", "abaqus/pendulum.inp"},
       [](const std::string& f) {
         return read_abaqus({f + "pendulum.inp", f + "coordinate_STIF1.mtx", f + "coordinate_MASS1.mtx"});
       },
       1e-16,
       1e-9,
       true},
      {"abaqus, matrix input",
       {"abaqus/labels_STIF1.mtx", "abaqus/labels_MASS1.mtx", "abaqus/pendulum.inp"},
       [](const std::string& f) {
         return read_abaqus({f + "pendulum.inp", f + "labels_STIF1.mtx", f + "labels_MASS1.mtx"});
       },
       1e-16,
       1e-9,
       true},
      // Punched with ten digits. phi' K phi of the first hinged mode is 3e-7 of phi' |K| phi, so that half a unit of
      // the tenth digit is up to 8e-4 of its frequency; as the errors are of either sign, some 5e-5 of it come about.
      {"nastran, DMIG",
       {"nastran/pendulum.bdf", "nastran/pendulum.pch"},
       [](const std::string& f) {
         return read_nastran({f + "pendulum.bdf", {f + "pendulum.pch"}});
       },
       5e-10,
       1e-4,
       true},
      {"nastran, OUTPUT4 text",
       {"nastran/pendulum.bdf", "nastran/pendulum_text.op4"},
       [](const std::string& f) {
         return read_nastran({f + "pendulum.bdf", {f + "pendulum_text.op4"}});
       },
       1e-16,
       1e-9,
       true},
      {"nastran, OUTPUT4 binary",
       {"nastran/pendulum.bdf", "nastran/pendulum_binary.op4"},
       [](const std::string& f) {
         return read_nastran({f + "pendulum.bdf", {f + "pendulum_binary.op4"}});
       },
       1e-16,
       1e-9,
       true},
  };
  return all;
}

class Formats : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = ::testing::TempDir() + "lithe_formats_" + test->name() + "/";
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& file) const { return folder_ + file; }
  std::string write(const std::string& file, const std::string& text) const {
    std::ofstream(path(file), std::ios::binary) << text;
    return path(file);
  }
  static std::string source(const std::string& file) {
    if (file == "abaqus/pendulum.inp") return pendulum_path("hex8i", "calculix/matrices.inp");  // the same language
    return std::string(LITHE_TEST_DATA) + "/formats/" + file;
  }
  static std::string base(const std::string& file) { return file.substr(file.find('/') + 1); }
  const Format& copied(const std::string& name) const {
    for (const Format& format : formats()) {
      if (format.name != name) continue;
      for (const std::string& file : format.files) write(base(file), text_of(source(file)));
      return format;
    }
    throw std::logic_error(name);
  }
  void replace(const std::string& file, const std::string& from, const std::string& to) const {
    std::string text = text_of(path(file));
    const size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    write(file, text.replace(at, from.size(), to));
  }

  std::string folder_;
};

/// Largest relative difference of frequencies, rigid ones left out.
double deviation(const VectorX& a, const VectorX& b) {
  double worst = 0;
  for (Eigen::Index k = 0; k < b.size(); ++k)
    if (b[k] > 0.1) worst = std::max(worst, std::abs(a[k] / b[k] - 1));
  return worst;
}

TEST_F(Formats, OneBodyInEveryFormatHasTheSameTenFrequencies) {
  const FiniteElementModel reference = pendulum("hex8i");
  std::vector<int> hinge;
  for (int id : reference.node_set("hinge"))
    for (int axis = 0; axis < 3; ++axis) hinge.push_back(3 * reference.node_index(id) + axis);
  const VectorX free = frequencies(reference, {}, 16), held = frequencies(reference, hinge, 12);
  ASSERT_GT(free[6], 1.0);
  for (const Format& format : formats()) {
    const FiniteElementModel model = copied(format.name).read(folder_);
    EXPECT_EQ(model.node_ids, reference.node_ids) << format.name;
    EXPECT_LT((model.nodes - reference.nodes).cwiseAbs().maxCoeff(), 1e-15) << format.name;
    EXPECT_TRUE(model.rotations.empty()) << format.name;
    const double K = difference(model.stiffness, reference.stiffness), M = difference(model.mass, reference.mass);
    EXPECT_LE(K, format.matrix_bound) << format.name;
    EXPECT_LE(M, format.matrix_bound) << format.name;
    EXPECT_NEAR(check(model).mass, check(reference).mass, format.matrix_bound) << format.name;
    const double free_off = deviation(frequencies(model, {}, 16), free);
    const double held_off = deviation(frequencies(model, hinge, 12), held);
    std::printf("%-24s K %.1e  M %.1e  frequencies free %.1e, hinged %.1e\n", format.name, K, M, free_off, held_off);
    EXPECT_LT(free_off, format.frequency_bound) << format.name;
    EXPECT_LT(held_off, format.frequency_bound) << format.name;
    if (!format.has_elements) continue;
    ASSERT_EQ(model.elements.size(), 1u) << format.name;
    EXPECT_EQ(model.elements[0].nodes, reference.elements[0].nodes) << format.name;
  }
}

TEST_F(Formats, DmigLosesNothingWhereFieldsAreLongEnough) {
  const FiniteElementModel reference = pendulum("hex8i");
  std::ostringstream text;
  text.precision(17);
  for (const auto& [name, A] : {std::pair("K2GG", &reference.stiffness), std::pair("M2GG", &reference.mass)}) {
    text << "DMIG," << name << ",0,6,2\n";
    for (int j = 0; j < A->outerSize(); ++j) {
      text << "DMIG," << name << "," << j / 3 + 1 << "," << j % 3 + 1 << ",";
      for (SparseMatrix::InnerIterator e(*A, j); e; ++e)
        if (e.row() >= j)
          text << "\n,,"
               << ","
               << ","
               << "," << e.row() / 3 + 1 << "," << e.row() % 3 + 1 << "," << e.value();
      text << "\n";
    }
  }
  copied("nastran, DMIG");
  write("k.pch", text.str());
  const FiniteElementModel model = read_nastran({path("pendulum.bdf"), {path("k.pch")}});
  EXPECT_EQ(difference(model.stiffness, reference.stiffness), 0.0);
  EXPECT_EQ(difference(model.mass, reference.mass), 0.0);
}

TEST_F(Formats, NodeSetsComeAlong) {
  EXPECT_EQ(copied("ansys, Harwell-Boeing").read(folder_).node_set("HINGE"), (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(copied("abaqus, coordinate").read(folder_).node_set("TIP"), (std::vector<int>{50}));
}

TEST_F(Formats, StressStiffnessIsPutInTheOrderOfTheModel) {
  const FiniteElementModel model = copied("ansys, Harwell-Boeing").read(folder_);
  const SparseMatrix same = read_stress_stiffness_ansys(path("mass.matrix"), path("pendulum.mapping"), model);
  EXPECT_EQ(difference(same, model.mass), 0.0);
  FiniteElementModel beams = model;
  beams.rotations.push_back({0, 2});
  expect_error<FileError>([&] { read_stress_stiffness_ansys(path("mass.matrix"), path("pendulum.mapping"), beams); },
                          {"pendulum.mapping", "node 1, direction 6 has no row"});
}

TEST_F(Formats, EveryVariantOfOutput4IsTheSameMatrix) {
  MatrixX expected = VectorX{{2, 3, 0, 5, 7}}.asDiagonal();
  expected(0, 1) = expected(1, 0) = -1.5;
  expected(3, 4) = expected(4, 3) = -0.25;
  expected(0, 4) = expected(4, 0) = 0.125;
  int count = 0;
  for (const auto& file : std::filesystem::directory_iterator(std::string(LITHE_TEST_DATA) + "/formats/nastran")) {
    if (file.path().filename().string().rfind("small_", 0) != 0) continue;
    const auto matrices = read_op4(file.path().string());
    ASSERT_EQ(matrices.size(), 1u) << file.path();
    EXPECT_EQ(matrices[0].name, "kaa");
    EXPECT_EQ(MatrixX(matrices[0].matrix), expected) << file.path();
    ++count;
  }
  EXPECT_EQ(count, 27);
}

// ---- a beam of two nodes with rotations, a plate's worth of formats ---------------------------------------------

/// Euler-Bernoulli, bending about one axis and stretch: enough to have rotations, and a singular K of the right kind.
const char* const kBeamGrid = "GRID,1,,0.,0.,0.\nGRID,2,,2.,0.,0.\n";
/// K of u2 and the rotation about z at both nodes, E I = 1, l = 2; springs elsewhere keep each row filled.
std::string beam_dmig() {
  std::string text = "DMIG,KAAX,0,6,2\nDMIG,MAAX,0,6,2\n";
  const double k[4][4] = {{1.5, 1.5, -1.5, 1.5}, {1.5, 2, -1.5, 1}, {-1.5, -1.5, 1.5, -1.5}, {1.5, 1, -1.5, 2}};
  const int dofs[4][2] = {{1, 2}, {1, 6}, {2, 2}, {2, 6}};
  const auto at = [](const int(&dof)[2]) { return std::to_string(dof[0]) + "," + std::to_string(dof[1]); };
  for (int j = 0; j < 4; ++j)
    for (int i = j; i < 4; ++i)
      text += "DMIG,KAAX," + at(dofs[j]) + ",," + at(dofs[i]) + "," + std::to_string(k[i][j]) + "\n";
  for (int axis : {1, 3}) {
    const std::string a = std::to_string(axis);
    text += "DMIG,KAAX,1," + a + ",,1," + a + ",4.\n,2," + a + ",-4.\nDMIG,KAAX,2," + a + ",,2," + a + ",4.\n";
  }
  for (const char* dof : {"1,1", "1,2", "1,3", "2,1", "2,2", "2,3"})
    text += std::string("DMIG,MAAX,") + dof + ",," + dof + ",.5\n";
  for (const char* dof : {"1,6", "2,6"}) text += std::string("DMIG,MAAX,") + dof + ",," + dof + ",1.-3\n";
  return text;
}

TEST_F(Formats, RotationsOfNodesFollowTheTranslations) {
  write("beam.bdf", kBeamGrid + beam_dmig());
  const FiniteElementModel model = read_nastran({path("beam.bdf")});
  ASSERT_EQ(model.dof_count(), 8);
  ASSERT_EQ(model.rotations.size(), 2u);
  EXPECT_EQ(model.rotations[1].node, 1);
  EXPECT_EQ(model.rotations[1].axis, 2);
  EXPECT_EQ(model.stiffness.coeff(1, 4), -1.5);  // u2 of both nodes
  EXPECT_EQ(model.stiffness.coeff(6, 1), 1.5);
  EXPECT_EQ(model.stiffness.coeff(6, 7), 1.0);
  EXPECT_EQ(model.mass.coeff(7, 7), 1e-3);
  // Turning the beam about z meets no force: u = (0, x, 0), rotation 1.
  VectorX turn = VectorX::Zero(8);
  turn[4] = 2;
  turn[6] = turn[7] = 1;
  EXPECT_LT((model.stiffness * turn).norm(), 1e-12);
}

TEST_F(Formats, RowsOfNoNodeAreCondensedIfTheyHaveNoMass) {
  // A spring of 4 N/m in the x direction becomes two of 8 N/m with a scalar point between them.
  std::string text = beam_dmig();
  const std::string spring = "DMIG,KAAX,1,1,,1,1,4.\n,2,1,-4.\nDMIG,KAAX,2,1,,2,1,4.\n";
  ASSERT_NE(text.find(spring), std::string::npos);
  text.replace(text.find(spring), spring.size(),
               "DMIG,KAAX,1,1,,1,1,8.\n,9,0,-8.\nDMIG,KAAX,2,1,,2,1,8.\n,9,0,-8.\nDMIG,KAAX,9,0,,9,0,16.\n");
  write("beam.bdf", kBeamGrid + text);
  const FiniteElementModel model = read_nastran({path("beam.bdf")});
  ASSERT_EQ(model.dof_count(), 8);
  EXPECT_NEAR(model.stiffness.coeff(0, 0), 4, 1e-12);
  EXPECT_NEAR(model.stiffness.coeff(3, 0), -4, 1e-12);
  write("beam.bdf", kBeamGrid + text + "DMIG,MAAX,9,0,,9,0,.1\n");
  expect_error<FileError>([&] { read_nastran({path("beam.bdf")}); }, {"node 9, direction 0", "no node, but has mass"});
}

TEST_F(Formats, FieldsMayBeShortLongOrFree) {
  NastranDeck deck;
  write("a.bdf",
        "$ comment\nSET 1 = 1,2,3,4,5,6,7,8,9,10,\n 11,12,13\nBEGIN BULK\n"
        "GRID           1             1.5   -2.-3   3.+02\n"
        "GRID*                  2                          1.5D-1            -.25\n*                7.0E+00\n"
        "GRID,3,,1.,2.,3.,,$ note\n"
        "GRID    4                               \n"
        "CTETRA         7       1       1       2       3       4\n"
        "DMIG    KAA            0       6       2\n"
        "DMIG    KAA            1       1               1       1     2.0             \n"
        "               2       1    -1.0               3       3     0.5\n"
        "ENDDATA\nGRID,5,7,0.,0.,0.\n");
  read_nastran_deck(path("a.bdf"), deck);
  ASSERT_EQ(deck.node_ids, (std::vector<int>{1, 2, 3, 4}));
  EXPECT_EQ(deck.positions[0], Vector3(1.5, -2e-3, 300));
  EXPECT_EQ(deck.positions[1], Vector3(0.15, -0.25, 7));
  EXPECT_EQ(deck.positions[3], Vector3::Zero());
  ASSERT_EQ(deck.matrices.size(), 1u);
  ASSERT_EQ(deck.matrices[0].matrix.entries.size(), 3u);
  EXPECT_EQ(deck.matrices[0].matrix.entries[2].row, (DofRow{3, 3}));
  EXPECT_EQ(deck.matrices[0].matrix.entries[1].value, -1.0);
}

TEST_F(Formats, MidSideNodesOfNastranBricksAreReordered) {
  std::string text;
  for (int id = 1; id <= 20; ++id) text += "GRID," + std::to_string(id) + ",,0.,0.,0.\n";
  text += "CHEXA,1,1,1,2,3,4,5,6\n,7,8,9,10,11,12,13,14\n,15,16,17,18,19,20\n";
  NastranDeck deck;
  read_nastran_deck(write("brick.bdf", text), deck);
  ASSERT_EQ(deck.elements.size(), 1u);
  EXPECT_EQ(deck.elements[0].type, "C3D20");
  EXPECT_EQ(deck.elements[0].nodes[0],
            (std::vector<int>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 17, 18, 19, 20, 13, 14, 15, 16}));
}

TEST_F(Formats, AbaqusNamesRowsInCommentsAndWritesEitherTriangle) {
  write("deck.inp", "*NODE\n7, 0., 0., 0.\n3, 1., 0., 0.\n");
  // Row 1 is node 7: the order of the solver, not of labels.
  const std::string names =
      "** row, node, dof\n** 1, 7, 1\n** 2, 7, 2\n** 3, 7, 3\n** 4, 3, 1\n** 5, 3, 2\n** 6, 3, 3\n";
  const std::string mass = names + "1 1 1.\n2 2 1.\n3 3 1.\n4 4 2.\n5 5 2.\n6 6 2.\n";
  const std::string spring = "1 1 9.\n2 2 1.\n3 3 1.\n4 4 9.\n5 5 1.\n6 6 1.\n";
  write("m.mtx", mass);
  for (const char* off : {"1 4 -9.\n", "4 1 -9.\n", "1 4 -9.\n4 1 -9.\n"}) {
    write("k.mtx", names + spring + off);
    const FiniteElementModel model = read_abaqus({path("deck.inp"), path("k.mtx"), path("m.mtx")});
    EXPECT_EQ(model.node_ids, (std::vector<int>{7, 3}));
    EXPECT_EQ(model.mass.coeff(0, 0), 1.0);
    EXPECT_EQ(model.mass.coeff(3, 3), 2.0);
    EXPECT_EQ(model.stiffness.coeff(0, 3), -9.0);
    EXPECT_EQ(model.stiffness.coeff(3, 0), -9.0);
  }
  write("k.mtx", names + spring + "1 4 -9.\n4 1 -8.\n");
  expect_error<FileError>(
      [&] {
        read_abaqus({path("deck.inp"), path("k.mtx"), path("m.mtx")});
      },
      {"k.mtx", "not symmetric"});
}

TEST_F(Formats, AnsysWritesDenseMatricesMappingsOfTwoColumnsAndListings) {
  // Two nodes, 5 (at the origin) and 2, tied by a spring along x; all other rows are held to ground.
  std::string K = "%%MatrixMarket matrix array real symmetric\n6 6\n",
              M = "%%MatrixMarket matrix array real general\n6 6\n";
  for (int j = 0; j < 6; ++j) {
    for (int i = j; i < 6; ++i) K += i == j ? "2.\n" : i == 3 && j == 0 ? "-2.\n" : "0.\n";
    for (int i = 0; i < 6; ++i) M += i == j ? (j < 3 ? "1.\n" : "3.\n") : "0.\n";
  }
  write("k.mmf", K);
  write("m.mmf", M);
  write("map.mmf", "%%MatrixMarket matrix array integer general\n6 2\n5\n5\n5\n2\n2\n2\n1\n2\n3\n1\n2\n3\n");
  write(
      "nodes.lis",
      " LIST ALL SELECTED NODES.   DSYS=      0\n\n   NODE        X           Y           Z     THXY    THYZ    THZX\n"
      "      2   1.5  0.0 -1.0E-3  0.00  0.00  0.00\n      5   0.0 0.0 0.0  0.00  0.00  0.00\n");
  const AnsysFiles files{path("k.mmf"), path("m.mmf"), path("map.mmf"), path("nodes.lis")};
  const FiniteElementModel model = read_ansys(files);
  EXPECT_EQ(model.node_ids, (std::vector<int>{2, 5}));
  EXPECT_EQ(Vector3(model.nodes.col(0)), Vector3(1.5, 0, -1e-3));
  EXPECT_EQ(model.stiffness.coeff(0, 3), -2.0);
  EXPECT_EQ(model.mass.coeff(0, 0), 3.0);
  EXPECT_EQ(model.mass.coeff(3, 3), 1.0);
  replace("nodes.lis", "-1.0E-3  0.00", "-1.0E-3  30.0");
  expect_error<FileError>([&] { read_ansys(files); }, {"nodes.lis:4", "turned axes"});
  write("k.mmf", K.substr(0, K.size() - 3));
  expect_error<FileError>([&] { read_ansys(files); }, {"turned axes"});
  replace("nodes.lis", "-1.0E-3  30.0", "-1.0E-3  0.00");
  expect_error<FileError>([&] { read_ansys(files); }, {"k.mmf:22", "column 6"});
}

TEST_F(Formats, RowsOfOutput4MayBeListed) {
  const FiniteElementModel reference = copied("nastran, OUTPUT4 text").read(folder_);
  std::string rows;
  for (int node = 1; node <= 54; ++node)
    for (int direction = 1; direction <= 6; ++direction)
      rows += std::to_string(node) + " " + std::to_string(direction) + "\n";
  write("rows.txt", rows);
  NastranFiles files{path("pendulum.bdf"), {path("pendulum_text.op4")}, "kgg", "MGG", path("rows.txt")};
  EXPECT_EQ(difference(read_nastran(files).stiffness, reference.stiffness), 0.0);
  // In another order the rows are other nodes' rows.
  write("rows.txt", rows.substr(24) + rows.substr(0, 24));
  EXPECT_EQ(read_nastran(files).mass.coeff(3, 3), reference.mass.coeff(0, 0));
  write("rows.txt", rows.substr(4));
  expect_error<FileError>([&] { read_nastran(files); }, {"324 rows, of which 323 are named"});
  files.stiffness = "KXX";
  expect_error<FileError>([&] { read_nastran(files); }, {"'KXX'", "found are kgg, mgg"});
}

TEST_F(Formats, RightHandSidesOfHarwellBoeingAreSkippedAndPlainNumbersRead) {
  const std::string matrix =
      "title                                                                   key\n"
      "             5             1             1             1             1\n"
      "RUA                        2             2             4             0\n"
      "(3I4)           (4I3)           (4F7.2)             (2F7.2)\nF                          1             0\n"
      "   1   3   5\n  1  2  1  2\n   2.00  -1.00  -1.00   2.00\n   1.00   1.00\n";
  const SparseMatrix A = read_harwell_boeing(write("a.rua", matrix));
  EXPECT_EQ(MatrixX(A), (MatrixX(2, 2) << 2, -1, -1, 2).finished());
}

// ---- damaged files ----------------------------------------------------------------------------------------------

struct Damage {
  const char *format, *file, *from, *to;
  std::vector<std::string> mentions;
};

TEST_F(Formats, DamagedFilesAreRefusedWithFileLineAndFix) {
  const char *hb = "ansys, Harwell-Boeing", *mmf = "ansys, Matrix Market", *coordinate = "abaqus, coordinate";
  const char *labels = "abaqus, matrix input", *dmig = "nastran, DMIG", *op4 = "nastran, OUTPUT4 text";
  const std::vector<Damage> damages = {
      {hb, "stiffness.matrix", "RSA ", "RSE ", {"stiffness.matrix:3", "'RSE'"}},
      {hb, "stiffness.matrix", "RSA ", "CSA ", {"stiffness.matrix:3", "'CSA'"}},
      {hb, "stiffness.matrix", "           162           162", "    2000000000    2000000000", {"stiffness.matrix:"}},
      {hb, "stiffness.matrix", "162          3223", "162          3222", {"stiffness.matrix:167", "3223", "3222"}},
      {hb, "stiffness.matrix", "(d25.15)", "(x25.15)", {"stiffness.matrix:4", "(x25.15)"}},
      {hb, "stiffness.matrix", "D+05", "D+xx", {"stiffness.matrix:", "not a number"}},
      {hb, "stiffness.matrix", "D+05", "D999", {"stiffness.matrix:", "not a finite number"}},
      {hb, "mass.matrix", "(10I8)", "(10X8)", {"mass.matrix:4", "(10X8)"}},
      {hb, "mass.matrix", "       1      13", "       1      12", {"mass.matrix:", "in column 2"}},
      {hb, "mass.matrix", "      13      25", "      25      13", {"mass.matrix:5", "column pointer 13"}},
      {hb, "mass.matrix", "       1      49", "       1     163", {"mass.matrix:22", "row 163 after row 1"}},
      {hb, "mass.matrix", "       1      49", "       1       1", {"mass.matrix:22", "row 1 after row 1"}},
      {hb, "pendulum.mapping", "UY", "VY", {"pendulum.mapping:3", "'VY'", "ROTX"}},
      {hb, "pendulum.mapping", "UY", "TEMP", {"pendulum.mapping:3", "'TEMP'"}},
      {hb, "pendulum.mapping", "UY", "UX", {"pendulum.mapping", "row 2 belongs to node", "as does row 1"}},
      {hb, "pendulum.mapping", "UY", "ROTY", {"pendulum.mapping", "no row for direction 2", "free body"}},
      {hb, "pendulum.mapping", "\n             2", "\n             3", {"pendulum.mapping:3", "row 3 follows row 1"}},
      {hb, "nodes.cdb", "        54\n", "        53\n", {"nodes.cdb:58", "54 nodes instead of the 53"}},
      {hb, "nodes.cdb", "(3i9,6e21.13e3)", "(3i9;6e21.13e3)", {"nodes.cdb:3"}},
      {hb, "nodes.cdb", "        2        0", "        1        0", {"nodes.cdb:5", "node 1 is given twice"}},
      {hb, "nodes.cdb", "        9        0", "       99        0", {"nodes.cdb", "names node 9,"}},
      {hb, "nodes.cdb", "N,R5.3", "M,R5.3", {"nodes.cdb:58"}},
      {hb, "nodes.cdb", "        -3", "       -99", {"nodes.cdb", "'hinge' names node"}},
      {hb, "nodes.cdb", "       54       48\n", "       99       48\n", {"nodes.cdb", "names node 99"}},
      {hb,
       "nodes.cdb",
       "        8        0       16",
       "       20        0       16",
       {"nodes.cdb:78", "column 2 is empty"}},
      {mmf, "stiffness.mmf", "162 162 3223", "162 162 3224", {"stiffness.mmf", "3223 of 3224"}},
      {mmf, "stiffness.mmf", "real symmetric", "complex symmetric", {"stiffness.mmf:1", "complex"}},
      {mmf, "mass.mmf", "\n1 1 ", "\n1 163 ", {"mass.mmf:4", "163"}},
      {mmf, "mass.mmf", "E-004", "E-nan", {"mass.mmf:5", "not a number"}},
      {mmf, "mapping.mmf", "54 1", "53 1", {"mapping.mmf:2", "53 x 1"}},
      {mmf, "mapping.mmf", "54 1\n", "54 1\n1.5\n", {"mapping.mmf:3", "whole number"}},
      {mmf, "nodes.node", "\n       9 ", "\n      99 ", {"mapping.mmf", "node 9,", "no coordinates"}},
      {mmf, "nodes.node", "      54 ", "      55 ", {"mapping.mmf", "node 54", "no coordinates"}},
      {mmf, "nodes.node", "\n       9 ", "\n      99 ", {"mapping.mmf", "node 9,", "no coordinates"}},
      {mmf, "nodes.node", "      54 ", "     5.4 ", {"mapping.mmf", "node 54"}},
      {mmf, "nodes.node", "0.0050000000000", "0.005000000000O", {"nodes.node:2", "not a number"}},
      {coordinate, "coordinate_STIF1.mtx", "\n2 1 ", "\n2 999 ", {"coordinate_STIF1.mtx:2", "999"}},
      {coordinate, "coordinate_STIF1.mtx", "\n2 1 ", "\n0 1 ", {"coordinate_STIF1.mtx:2", "row or column 0"}},
      {coordinate, "coordinate_STIF1.mtx", "\n2 1 ", "\n1 1 ", {"coordinate_STIF1.mtx", "given twice"}},
      {coordinate, "coordinate_STIF1.mtx", "\n2 1 ", "\n2 1 3 ", {"coordinate_STIF1.mtx:2", "4 numbers"}},
      {coordinate, "coordinate_STIF1.mtx", "e+05", "e+36", {"coordinate_STIF1.mtx:2", "boundary condition"}},
      {coordinate, "coordinate_STIF1.mtx", "162 162 ", "163 163 ", {"coordinate_STIF1.mtx", "163 rows for 54 nodes"}},
      {coordinate, "coordinate_MASS1.mtx", "e-04", "inf", {"coordinate_MASS1.mtx:1"}},
      {coordinate, "coordinate_MASS1.mtx", "1 1 ", "*ELEMENT\n1 1 ", {"coordinate_MASS1.mtx:1", "*element"}},
      {coordinate, "pendulum.inp", "54,0.1", "53,0.1", {"pendulum.inp:56", "defined twice"}},
      {labels, "labels_STIF1.mtx", "\n1,2, 1,1", "\n1,7, 1,1", {"labels_STIF1.mtx", "direction 7"}},
      {labels, "labels_STIF1.mtx", "\n1,2, 1,1", "\n99,2, 1,1", {"labels_STIF1.mtx", "node 99", "no coordinates"}},
      {labels, "labels_STIF1.mtx", "\n1,2, 1,1", "\n1,2, 1", {"labels_STIF1.mtx:2", "4 numbers"}},
      {labels, "labels_STIF1.mtx", "\n1,2, 1,1", "\n1,2, 1,x", {"labels_STIF1.mtx:2", "'x'"}},
      {labels, "labels_STIF1.mtx", "\n1,2, 1,2, ", "\n1,2, 1,2, -", {"labels_STIF1.mtx", "no positive stiffness"}},
      {labels, "labels_MASS1.mtx", "\n1,2, 1,2, ", "\n1,1, 1,2, ", {"no positive mass"}},
      {labels, "pendulum.inp", "\n54,", "\n55,", {"pendulum.inp", "node 54"}},
      {dmig, "pendulum.pch", "       6       2", "       6       7", {"pendulum.pch:1", "type 7"}},
      {dmig, "pendulum.pch", "       6       2", "       6       3", {"pendulum.pch", "kaax", "found are maax"}},
      {dmig, "pendulum.pch", "DMIG    MAAX", "DMIG    KAAX", {"pendulum.pch:", "second header of kaax"}},
      {dmig, "pendulum.pch", "DMIG    MAAX", "DMIG    MBBX", {"pendulum.pch:", "maax before its header"}},
      {dmig, "pendulum.pch", "8.722136319D+04", "8.722136319D+xx", {"pendulum.pch:2", "not a number"}},
      {dmig, "pendulum.pch", "8.722136319D+04", "            nan", {"pendulum.pch:2", "finite"}},
      {dmig, "pendulum.pch", "1 8.722136319D+04", "9 8.722136319D+04", {"pendulum.pch:2", "direction 9"}},
      {dmig,
       "pendulum.pch",
       "\n*                      1               2",
       "\n*                      1               1",
       {"pendulum.pch", "twice"}},
      {dmig,
       "pendulum.bdf",
       "GRID*                  1                ",
       "GRID*                  1               3",
       {"pendulum.bdf:4", "coordinate system 3"}},
      {dmig,
       "pendulum.bdf",
       "GRID*                  2",
       "GRID*                  1",
       {"pendulum.bdf:6", "defined twice"}},
      {dmig, "pendulum.bdf", "CHEXA ", "CTETRA", {"pendulum.bdf:112", "8 nodes"}},
      {dmig, "pendulum.bdf", "BEGIN BULK", "BEGIN BULK\nINCLUDE 'x'", {"pendulum.bdf:4", "INCLUDE"}},
      {op4, "pendulum_text.op4", "     324     324", "     324     325", {"pendulum_text.op4", "found are mgg"}},
      {op4, "pendulum_text.op4", "       2KGG", "       9KGG", {"pendulum_text.op4:1", "type 9"}},
      {op4, "pendulum_text.op4", "1P,3E23.16", "1P,3Z23.16", {"pendulum_text.op4:1", "format"}},
      {op4, "pendulum_text.op4", "      56", "      57", {"pendulum_text.op4:"}},
      {op4, "pendulum_text.op4", "      458753", "      459076", {"pendulum_text.op4:3", "rows 324 to 3"}},
      {op4,
       "pendulum_text.op4",
       "\n       2       0",
       "\n       1       0",
       {"pendulum_text.op4:", "column 1 after column 1"}},
      {op4, "pendulum_text.op4", "8.7221363191063312E+04", "8.7221363191063312E+xx", {"pendulum_text.op4:4", "number"}},
      {op4, "pendulum_text.op4", "8.7221363191063312E+04", "                  -inf", {"pendulum_text.op4:4", "finite"}},
  };
  for (const Damage& damage : damages) {
    SCOPED_TRACE(std::string(damage.file) + ": '" + damage.from + "' becomes '" + damage.to + "'");
    const Format& format = copied(damage.format);
    replace(damage.file, damage.from, damage.to);
    expect_error<FileError>([&] { format.read(folder_); }, damage.mentions);
  }
  std::printf("%zu kinds of damage\n", damages.size());
}

TEST_F(Formats, CutFilesAreRefusedWhereverTheyEnd) {
  for (const Format& format : formats()) {
    copied(format.name);
    for (const std::string& file : format.files) {
      const std::string name = base(file), whole = text_of(path(name));
      if (name == "pendulum.inp" || name == "pendulum.bdf") continue;  // a deck may end after any line that is whole
      for (size_t part : {0, 1, 3, 7, 12, 19, 20}) {
        if (name == "nodes.cdb" && part == 20) continue;  // a component less is not seen
        const size_t length = part < 20 ? whole.size() * part / 20 : whole.size() - 45;
        for (size_t end : {length, whole.rfind('\n', length) + 1}) {
          SCOPED_TRACE(file + " ends after " + std::to_string(end) + " bytes");
          write(name, whole.substr(0, end));
          expect_error<FileError>([&] { format.read(folder_); }, {folder_});
        }
      }
      write(name, whole);
    }
  }
}

TEST_F(Formats, DamagedRecordsOfBinaryOutput4AreRefused) {
  const Format& format = copied("nastran, OUTPUT4 binary");
  const std::string whole = text_of(path("pendulum_binary.op4"));
  const auto with = [&](size_t at, const std::string& bytes) {
    std::string text = whole;
    return text.replace(at, bytes.size(), bytes);
  };
  const auto word = [](int value) { return std::string(reinterpret_cast<const char*>(&value), 4); };
  const std::string nan = "\xff\xff\xff\xff\xff\xff\xff\x7f";
  // The header's record is 4 + 24 + 4 bytes; that of column 1: length, 1, 0, words, length and row of a run, values.
  const std::vector<std::pair<std::string, std::vector<std::string>>> damages = {
      {with(4, word(2'000'000'000)), {"byte", "2000000000"}},   // columns
      {with(8, word(-2'000'000'000)), {"byte", "2000000000"}},  // rows
      {with(16, word(9)), {"type 9"}},
      {with(28, word(25)), {"two lengths differ"}},
      {with(32, word(1'000'000'000)), {"goes beyond the end"}},
      {with(36, word(5)), {"column 2 after column 5"}},
      {with(44, word(4)), {"byte 32"}},  // words of the column
      {with(48, word(-3)), {"byte 32", "words goes beyond its column"}},
      {with(52, word(400)), {"byte 32", "rows 400"}},
      {with(56, nan), {"byte 32", "not a finite number"}},
      {whole.substr(0, whole.size() / 2), {"byte"}},
      {whole.substr(0, 60), {"byte 32", "beyond the end"}},
  };
  for (const auto& [text, mentions] : damages) {
    write("pendulum_binary.op4", text);
    auto all = mentions;
    all.push_back("pendulum_binary.op4");
    expect_error<FileError>([&] { format.read(folder_); }, all);
  }
}

TEST_F(Formats, SupportsInTheMatricesAreNamed) {
  copied("nastran, DMIG");
  // Node 54 is held along z: its row and column are gone from both matrices.
  std::istringstream lines(text_of(path("pendulum.pch")));
  std::string text, line;
  const std::string dof = "              54               3";
  for (bool skip = false; std::getline(lines, line);) {
    const bool head = line.rfind("DMIG", 0) == 0;
    if (head) skip = line.find(dof) != std::string::npos;
    if (!skip && (head || line.find(dof) != 8)) text += line + "\n";
  }
  write("pendulum.pch", text);
  expect_error<FileError>(
      [&] {
        read_nastran({path("pendulum.bdf"), {path("pendulum.pch")}});
      },
      {"pendulum.pch", "node 54 has no row for direction 3", "free body"});
}

}  // namespace
}  // namespace lithe::test::fe_formats_test
