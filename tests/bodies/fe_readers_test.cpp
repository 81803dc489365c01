#include <filesystem>

#include "bodies/flexible/readers/text_file.h"
#include "tests/bodies/fe_models.h"

namespace lithe::test::fe_readers_test {
namespace {

using test::difference;
using test::expect_error;
using test::pendulum;
using test::pendulum_from_calculix;
using test::pendulum_path;

std::string text_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  EXPECT_TRUE(stream) << path;
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// A folder of its own for each test, with files written, copied or edited.
class Readers : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = ::testing::TempDir() + "lithe_" + test->name() + "/";
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& file) const { return folder_ + file; }
  void write(const std::string& file, const std::string& text) const {
    std::ofstream(path(file), std::ios::binary) << text;
  }
  /// The CalculiX export of the main body, to be spoiled.
  void copy_calculix() const {
    for (const char* extension : {"inp", "sti", "mas", "dof"})
      write("rod." + std::string(extension),
            text_of(pendulum_path("hex8i", "calculix/matrices." + std::string(extension))));
  }
  void copy_tables() const {
    for (const char* file : {"K.mtx", "M.mtx", "nodes.csv", "node_sets.csv", "elements.csv"})
      write(file, text_of(pendulum_path("hex8i", file)));
  }
  void replace(const std::string& file, const std::string& from, const std::string& to) const {
    std::string text = text_of(path(file));
    const size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    write(file, text.replace(at, from.size(), to));
  }
  void cut(const std::string& file, double keep) const {
    const std::string text = text_of(path(file));
    write(file, text.substr(0, static_cast<size_t>(keep * static_cast<double>(text.size()))));
  }
  FiniteElementModel read_job() const { return read_calculix(path("rod")); }
  FiniteElementModel read_tables() const {
    return read_matrix_market(path("K.mtx"), path("M.mtx"), path("nodes.csv"), path("node_sets.csv"),
                              path("elements.csv"));
  }

 private:
  std::string folder_;
};

TEST_F(Readers, CalculixFilesAndMatrixMarketFilesAreTheSameModel) {
  for (const char* body : {"hex8i", "hex20", "paper", "stiff"}) {
    const FiniteElementModel a = pendulum_from_calculix(body), b = pendulum(body);
    const double K = difference(a.stiffness, b.stiffness), M = difference(a.mass, b.mass);
    std::printf("%s: CalculiX against Matrix Market, K %.1e, M %.1e\n", body, K, M);
    EXPECT_LT(K, 2e-13) << body;  // 14 printed digits
    EXPECT_LT(M, 1e-13) << body;
    EXPECT_EQ(a.node_ids, b.node_ids);
    EXPECT_EQ(a.nodes, b.nodes);
    for (const auto& [set, members] : b.node_sets) EXPECT_EQ(a.node_set(set), members) << body << " " << set;
    ASSERT_EQ(a.elements.size(), 1u);
    EXPECT_EQ(a.elements[0].nodes, b.elements[0].nodes);
  }
  EXPECT_EQ(pendulum_from_calculix("hex8i").elements[0].type, "C3D8I");
  EXPECT_EQ(pendulum("hex20").elements[0].type, "C3D20");
}

TEST_F(Readers, AnyFileOfACalculixJobNamesTheJob) {
  copy_calculix();
  for (const char* job : {"rod", "rod.inp", "rod.sti", "rod.mas", "rod.dof"})
    EXPECT_EQ(read_calculix(path(job)).node_count(), 54) << job;
}

TEST_F(Readers, RowsArePlacedByTheDofFile) {
  // Rows 1-3 (node 1) and 4-6 (node 2) change places in .dof: so do their rows in K.
  copy_calculix();
  const FiniteElementModel straight = read_job();
  replace("rod.dof", "1.1\n1.2\n1.3\n2.1\n2.2\n2.3\n", "2.1\n2.2\n2.3\n1.1\n1.2\n1.3\n");
  const FiniteElementModel swapped = read_job();
  EXPECT_EQ(swapped.stiffness.coeff(0, 0), straight.stiffness.coeff(3, 3));
  EXPECT_EQ(swapped.stiffness.coeff(1, 20), straight.stiffness.coeff(4, 20));
  EXPECT_EQ(swapped.mass.coeff(5, 5), straight.mass.coeff(2, 2));
}

TEST_F(Readers, DecksMayIncludeGenerateNestAndUseAnyCase) {
  copy_calculix();
  const std::string deck = text_of(path("rod.inp"));
  const size_t split = deck.find("*ELEMENT");
  write("mesh.inc", deck.substr(0, split));
  write("rod.inp", "*Heading\n text, 1, 2\n*include, input=mesh.inc\n" + deck.substr(split) +
                       "*nset, nset=Row, generate\n1, 53, 13,\n*Nset, NSET = Both\nrow, TIP, 1, 7\n");
  const FiniteElementModel model = read_job();
  EXPECT_EQ(model.node_count(), 54);
  EXPECT_EQ(model.node_set("row"), (std::vector<int>{1, 14, 27, 40, 53}));
  EXPECT_EQ(model.node_set("both"), (std::vector<int>{1, 14, 27, 40, 53, 50, 7}));
  EXPECT_EQ(model.node_set("nall").size(), 54u);
}

TEST_F(Readers, ElementsBeyondOneLineAreReadWhole) {
  const auto model = pendulum_from_calculix("hex20");
  ASSERT_EQ(model.elements.size(), 1u);
  for (const auto& element : model.elements[0].nodes) EXPECT_EQ(element.size(), 20u);
}

TEST_F(Readers, UnusedNodesOfADeckAreLeftOut) {
  copy_calculix();
  replace("rod.inp", "*ELEMENT", "*NODE, NSET=SPARE\n999, 1., 2., 3.\n*ELEMENT");
  const FiniteElementModel model = read_job();
  EXPECT_EQ(model.node_count(), 54);
  EXPECT_TRUE(model.node_set("spare").empty());
}

TEST_F(Readers, AMissingFileIsNamed) {
  expect_error<FileError>([&] { read_calculix(path("nothing")); }, {"no such file", "nothing.inp"});
  copy_calculix();
  std::filesystem::remove(path("rod.mas"));
  expect_error<FileError>([&] { read_job(); }, {"no such file", "rod.mas", "MATRIXSTORAGE"});
  expect_error<FileError>([&] { read_tables(); }, {"no such file", "nodes.csv"});
  std::filesystem::create_directories(path("nodes.csv"));
  expect_error<FileError>([&] { read_tables(); }, {"folder"});
}

TEST_F(Readers, ATruncatedCalculixMatrixIsCaughtWhereverItEnds) {
  copy_calculix();
  for (const char* file : {"rod.sti", "rod.mas"}) {
    const std::string whole = text_of(path(file));
    const size_t line_end = whole.rfind('\n', whole.size() / 2) + 1;
    for (size_t length : {size_t{0}, line_end, line_end + 3, line_end + 12, whole.size() - 1, whole.size() - 30}) {
      write(file, whole.substr(0, length));
      expect_error<FileError>([&] { read_job(); }, {file});
    }
    write(file, whole);
  }
  const std::string rows = text_of(path("rod.dof"));
  for (size_t length : {size_t{0}, rows.size() / 2, rows.size() - 1, rows.size() - 6}) {
    write("rod.dof", rows.substr(0, length));
    expect_error<FileError>([&] { read_job(); }, {"rod."});
  }
}

TEST_F(Readers, ACutDeckIsCaught) {
  copy_calculix();
  const std::string deck = text_of(path("rod.inp"));
  for (const char* text : {"3,7,13,14,8", "25,0.05,0.0", "*ELEMENT"}) {
    write("rod.inp", deck.substr(0, deck.find(text) + 3));
    expect_error<FileError>([&] { read_job(); }, {"rod."});
  }
}

TEST_F(Readers, WordsThatAreNoNumbersAreNamedWithTheirLine) {
  copy_calculix();
  replace("rod.sti", "2 2  7.1687795177728e+05", "2 2  7.16x");
  expect_error<FileError>([&] { read_job(); }, {"rod.sti:3", "'7.16x', not a number"});
  copy_calculix();
  replace("rod.mas", "\n2 2 ", "\n2 two ");
  expect_error<FileError>([&] { read_job(); }, {"rod.mas:3", "'two', not a whole number"});
  copy_calculix();
  replace("rod.inp", "3,0.0,0.01,0.0", "3,0.0,O.01,0.0");
  expect_error<FileError>([&] { read_job(); }, {"rod.inp:5", "'O.01'"});
}

TEST_F(Readers, NaNAndInfinityAreRefused) {
  copy_calculix();
  replace("rod.sti", "7.1687795177728e+05", "nan");
  expect_error<FileError>([&] { read_job(); }, {"rod.sti:3", "not a finite number"});
  copy_calculix();
  replace("rod.sti", "7.1687795177728e+05", "1e999");
  expect_error<FileError>([&] { read_job(); }, {"rod.sti:3", "not a finite number"});
  copy_tables();
  replace("nodes.csv", "2,0.0,0.005,0.0", "2,inf,0.005,0.0");
  expect_error<FileError>([&] { read_tables(); }, {"nodes.csv:3", "'inf'"});
  copy_tables();
  replace("K.mtx", "1 1 87221.363191063312", "1 1 NaN");
  expect_error<FileError>([&] { read_tables(); }, {"K.mtx:5", "not a finite number"});
}

TEST_F(Readers, RowsOutOfRangeAreRefused) {
  copy_calculix();
  replace("rod.sti", "\n2 2 ", "\n2 307 ");
  expect_error<FileError>([&] { read_job(); }, {"rod.sti:3", "307", "306 rows"});
  copy_calculix();
  replace("rod.sti", "\n2 2 ", "\n0 2 ");
  expect_error<FileError>([&] { read_job(); }, {"rod.sti:3", "row or column 0"});
}

TEST_F(Readers, AnEntryGivenTwiceIsRefused) {
  copy_calculix();
  replace("rod.sti", "2 2  7", "2 1  1.0\n2 2  7");
  expect_error<FileError>([&] { read_job(); }, {"rod.sti", "row 2, column 1", "twice"});
}

TEST_F(Readers, RowsThatDoNotBelongToTheDeckAreRefused) {
  copy_calculix();
  replace("rod.dof", "\n102.3", "");  // one hidden row less than nine an element
  expect_error<FileError>([&] { read_job(); }, {"143 rows", "16 C3D8I elements account for 144"});
  copy_calculix();
  replace("rod.inp", "TYPE=C3D8I", "TYPE=C3D8");
  expect_error<FileError>([&] { read_job(); }, {"144 rows", "0 C3D8I"});
  copy_calculix();
  replace("rod.dof", "\n7.3", "");  // a supported or dependent degree of freedom
  expect_error<FileError>([&] { read_job(); }, {"node 7 has no row for direction 3", "*BOUNDARY"});
  copy_calculix();
  replace("rod.dof", "\n7.3", "\n7.2");
  expect_error<FileError>([&] { read_job(); }, {"rod.dof:21", "node 7, direction 2 has two rows"});
  copy_calculix();
  replace("rod.dof", "\n7.3", "\n7.4");
  expect_error<FileError>([&] { read_job(); }, {"rod.dof:21", "direction 4"});
}

TEST_F(Readers, UnknownNodesInADeckAreRefused) {
  copy_calculix();
  replace("rod.inp", "*NSET, NSET=TIP\n50,", "*NSET, NSET=TIP\n500,");
  expect_error<FileError>([&] { read_job(); }, {"node 500", "rod.inp:", "no *NODE"});
  copy_calculix();
  replace("rod.inp", "1,1,7,8,2,4,10,11,5", "1,1,7,8,2,4,10,11,55");
  expect_error<FileError>([&] { read_job(); }, {"node 55", "rod.inp:58"});
  copy_calculix();
  replace("rod.inp", "*NSET, NSET=TIP\n50,", "*NSET, NSET=TIP\nnobody,");
  expect_error<FileError>([&] { read_job(); }, {"'nobody'", "rod.inp:"});
  copy_calculix();
  replace("rod.inp", "54,0.1,0.01,0.015", "53,0.1,0.01,0.015");
  expect_error<FileError>([&] { read_job(); }, {"node 53 is defined twice", "rod.inp:56"});
}

TEST_F(Readers, ASlipInGenerateIsRefused) {
  copy_calculix();
  replace("rod.inp", "*STEP", "*NSET, NSET=ALL, GENERATE\n1, 2000000000\n*STEP");
  expect_error<FileError>([&] { read_job(); }, {"GENERATE", "ten million"});
}

TEST_F(Readers, ADamagedByteIsReadOrRefusedButNeverCrashes) {
  // Any byte of any file may be wrong: the answer is a model or a FileError, nothing else.
  unsigned random = 12345;
  const auto draw = [&random](size_t below) {
    random = random * 1664525u + 1013904223u;
    return static_cast<size_t>(random >> 8) % below;
  };
  const std::string alphabet = "0123456789.,-+eE *=\n\tNxI%";
  copy_calculix();
  copy_tables();
  int refused = 0;
  for (const char* file : {"rod.inp", "rod.dof", "rod.sti", "K.mtx", "nodes.csv", "node_sets.csv", "elements.csv"}) {
    const std::string whole = text_of(path(file));
    for (int trial = 0; trial < 25; ++trial) {
      std::string damaged = whole;
      damaged[draw(damaged.size())] = alphabet[draw(alphabet.size())];
      write(file, damaged);
      try {
        file[0] == 'r' ? read_job() : read_tables();
      } catch (const FileError&) {
        ++refused;
      }
    }
    write(file, whole);
  }
  EXPECT_GT(refused, 20);
}

TEST_F(Readers, TurnedAxesAndEndlessIncludesAreRefused) {
  copy_calculix();
  replace("rod.inp", "*STEP", "*TRANSFORM, NSET=TIP, TYPE=C\n0,0,0,0,0,1\n*STEP");
  expect_error<FileError>([&] { read_job(); }, {"*transform", "global axes"});
  write("rod.inp", "*INCLUDE, INPUT=rod.inp\n");
  expect_error<FileError>([&] { read_job(); }, {"*INCLUDE goes too deep"});
}

TEST_F(Readers, ATruncatedMatrixMarketFileIsCaught) {
  copy_tables();
  const std::string whole = text_of(path("K.mtx"));
  for (double keep : {0.0, 0.0001, 0.001, 0.5, 0.97}) {
    write("K.mtx", whole);
    cut("K.mtx", keep);
    expect_error<FileError>([&] { read_tables(); }, {"K.mtx"});
  }
  write("K.mtx", whole.substr(0, whole.rfind('\n', whole.size() - 2) + 1));
  expect_error<FileError>([&] { read_tables(); }, {"3222 of 3223 entries", "truncated"});
  write("K.mtx", whole + "1 1 2.0\n");
  expect_error<FileError>([&] { read_tables(); }, {"more entries than the 3223"});
}

TEST_F(Readers, ANonSymmetricGeneralMatrixIsRefusedAndASymmetricOneRead) {
  write("A.mtx",
        "%%MatrixMarket matrix coordinate real general\n% note\n\n3 3 5\n1 1 2\n2 2 +2e0\n3 3 2\n1 2 -1\n2 1 -1\n");
  const SparseMatrix A = read_matrix_market_file(path("A.mtx"));
  EXPECT_EQ(A.coeff(0, 1), -1.0);
  EXPECT_EQ(A.coeff(1, 0), -1.0);
  EXPECT_EQ(A.coeff(1, 1), 2.0);
  replace("A.mtx", "2 1 -1", "2 1 -1.1");
  expect_error<FileError>([&] { read_matrix_market_file(path("A.mtx")); },
                          {"not symmetric", "A.mtx", "row 2, column 1"});
  replace("A.mtx", "2 1 -1.1", "1 2 -1");
  expect_error<FileError>([&] { read_matrix_market_file(path("A.mtx")); }, {"given twice"});
}

TEST_F(Readers, OnlyRealCoordinateMatricesAreRead) {
  for (const char* kind : {"matrix array real general", "matrix coordinate complex symmetric",
                           "matrix coordinate pattern general", "matrix coordinate real skew-symmetric"}) {
    write("A.mtx", "%%MatrixMarket " + std::string(kind) + "\n1 1 1\n1 1 1\n");
    expect_error<FileError>([&] { read_matrix_market_file(path("A.mtx")); }, {"A.mtx:1", kind});
  }
  write("A.mtx", "%%MatrixMarket matrix coordinate real symmetric\n2 3 1\n1 1 1\n");
  expect_error<FileError>([&] { read_matrix_market_file(path("A.mtx")); }, {"A.mtx:2", "2 x 3"});
  write("A.mtx", "%%MatrixMarket matrix coordinate real symmetric\n2000000000 2000000000 1\n1 1 1\n");
  expect_error<FileError>([&] { read_matrix_market_file(path("A.mtx")); }, {"A.mtx:2", "some row is empty"});
}

TEST_F(Readers, MatricesAndNodesMustAgreeInNumber) {
  copy_tables();
  write("M.mtx", text_of(pendulum_path("paper", "M.mtx")));
  expect_error<FileError>([&] { read_tables(); }, {"M.mtx", "204 rows", "54 nodes", "162 degrees"});
  copy_tables();
  replace("nodes.csv", "54,0.1,0.01,0.015", "");
  replace("node_sets.csv", "set,position", "set,position");
  expect_error<FileError>([&] { read_matrix_market(path("K.mtx"), path("M.mtx"), path("nodes.csv")); },
                          {"K.mtx", "162 rows", "53 nodes"});
}

TEST_F(Readers, TablesThatDoNotFitAreRefused) {
  copy_tables();
  replace("node_sets.csv", "tip,1,50,", "tip,1,500,");
  expect_error<FileError>([&] { read_tables(); }, {"node_sets.csv:5", "node 500"});
  copy_tables();
  replace("node_sets.csv", "tip,1,50,", "tip,1,49,");
  expect_error<FileError>([&] { read_tables(); }, {"node_sets.csv:5", "node 49 stands elsewhere"});
  copy_tables();
  replace("node_sets.csv", "hinge,2,", "hinge,3,");
  expect_error<FileError>([&] { read_tables(); }, {"node_sets.csv:3", "position 3"});
  copy_tables();
  replace("elements.csv", "1,1,7,8,2,4,10,11,5", "1,1,7,8,2,4,10,11,55");
  expect_error<FileError>([&] { read_tables(); }, {"elements.csv:2", "node 55"});
  copy_tables();
  replace("elements.csv", "1,1,7,8,2,4,10,11,5", "1,1,7,8,2,4,10,11");
  expect_error<FileError>([&] { read_tables(); }, {"elements.csv:2", "7 nodes"});
  copy_tables();
  replace("nodes.csv", "2,0.0,0.005,0.0", "1,0.0,0.005,0.0");
  expect_error<FileError>([&] { read_tables(); }, {"nodes.csv:3", "node 1 is given twice"});
  copy_tables();
  replace("nodes.csv", "2,0.0,0.005,0.0", "2,0.0,0.005");
  expect_error<FileError>([&] { read_tables(); }, {"nodes.csv:3", "3 columns"});
  copy_tables();
  replace("nodes.csv", "node,x,y,z\n", "");
  expect_error<FileError>([&] { read_tables(); }, {"nodes.csv:1", "node,x,y,z"});
}

TEST_F(Readers, LinesFromAnotherSystemAreReadAlike) {
  copy_tables();
  for (const char* file : {"K.mtx", "nodes.csv"}) {
    std::string text;
    for (char c : text_of(path(file))) text += c == '\n' ? std::string("\r\n") : std::string(1, c);
    write(file, text);
  }
  const FiniteElementModel model = read_tables();
  EXPECT_EQ(model.nodes, pendulum("hex8i").nodes);
  EXPECT_EQ(difference(model.stiffness, pendulum("hex8i").stiffness), 0.0);
}

}  // namespace
}  // namespace lithe::test::fe_readers_test
