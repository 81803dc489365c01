// The fuzzers' inputs, read once more (tools/fuzz.sh); and files with a checksum, each of their bits flipped.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "bodies/flexible/basis_file.h"
#include "engine/base/error.h"
#include "engine/output/binary.h"
#include "engine/output/hdf5_table.h"
#include "tests/engine/output/output_scratch_folder.h"
#include "tools/fuzz/targets.h"

namespace lithe::test {
namespace {

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class Corpus : public testing::TestWithParam<fuzz::Target> {};

TEST_P(Corpus, is_read_into_what_is_sound_or_refused) {
  const fuzz::Target target = GetParam();
  int read = 0, refused = 0;
  for (const char* folder : {"/fuzz/", "/import/corpus/"}) {
    const std::filesystem::path inputs = std::string(LITHE_TEST_DATA) + folder + target.name;
    if (!std::filesystem::is_directory(inputs)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(inputs)) {
      const ScratchFolder scratch;
      try {
        target.run(bytes_of(entry.path()), scratch.path(""));
        ++read;
      } catch (const Error& error) {
        EXPECT_FALSE(error.problem().empty() || error.where().empty() || error.fix().empty()) << entry.path();
        ++refused;
      } catch (const fuzz::SilentAcceptance& wrong) {
        ADD_FAILURE() << entry.path() << " is taken as good: " << wrong.what();
      }
    }
  }
  EXPECT_GT(read + refused, 0) << "no corpus";
}

INSTANTIATE_TEST_SUITE_P(Fuzz, Corpus, testing::ValuesIn(fuzz::all_targets()),
                         [](const auto& test) { return std::string(test.param.name); });

/// How many of a file's single flipped bits are refused; what is read all the same must be the content itself, where a
/// bit had no meaning (a reserve, a time stamp). `stride`: every so many bits.
template <class Read, class Same>
void flip_bits(const char* name, Read read, Same same, std::size_t stride, double least_refused) {
  const std::string sound = bytes_of(std::string(LITHE_TEST_DATA) + "/fuzz/" + name + "/seed");
  ASSERT_FALSE(sound.empty());
  const ScratchFolder folder;
  const std::string path = folder.path("flipped");
  write_text(path, sound);
  const auto expected = read(path);
  int refused = 0, tried = 0;
  for (std::size_t bit = 0; bit < 8 * sound.size(); bit += stride, ++tried) {
    std::string bytes = sound;
    bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << bit % 8));
    std::filesystem::remove(path);
    write_text(path, bytes);
    try {
      EXPECT_TRUE(same(read(path), expected)) << "bit " << bit << " of " << name << " is taken as good";
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GE(refused, least_refused * tried) << name;
}

bool same_table(const Table& a, const Table& b) { return a.columns == b.columns && a.values == b.values; }
bool same_basis(const std::shared_ptr<const ModalBasis>& a, const std::shared_ptr<const ModalBasis>& b) {
  return a->name == b->name && a->origin == b->origin && a->rotation == b->rotation && a->node_ids == b->node_ids &&
         a->node_sets == b->node_sets && a->nodes == b->nodes && a->modes == b->modes && a->free_dofs == b->free_dofs &&
         a->frequencies == b->frequencies && a->integrals.mass == b->integrals.mass && a->diagonal == b->diagonal &&
         a->integrals.J0 == b->integrals.J0 && a->integrals.Mff == b->integrals.Mff && a->damping == b->damping &&
         a->stiffness.isApprox(b->stiffness, 0) && a->modal_mass.isApprox(b->modal_mass, 0) &&
         !a->deflection == !b->deflection && a->elements.size() == b->elements.size();
}

TEST(FlippedBits, of_a_binary_table_are_all_refused) { flip_bits("binary", read_binary, same_table, 1, 1); }
TEST(FlippedBits, of_an_hdf5_table_are_refused_or_mean_nothing) {
  flip_bits("hdf5_table", read_hdf5_table, same_table, 3, 0.2);
}
TEST(FlippedBits, of_a_reduced_body_are_refused_or_mean_nothing) {
  flip_bits("basis", read_modal_basis, same_basis, 53, 0.2);
}

}  // namespace
}  // namespace lithe::test
