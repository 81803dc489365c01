// The equations that comments cite are in the repository, under the number that they are cited by.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>

namespace lithe::test::citations_test {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = LITHE_SOURCE_DIR;
const std::string kEquations = "docs/equations.md";

std::string text_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

/// Numbers of its headings: "2.3" of "### 2.3 Modal form".
std::set<std::string> sections() {
  std::set<std::string> found;
  const std::string text = text_of(kRoot / kEquations);
  const std::regex heading(R"((?:^|\n)#{2,3} (\d+(?:\.\d+)?) )");
  for (std::sregex_iterator m(text.begin(), text.end(), heading), end; m != end; ++m) found.insert((*m)[1]);
  return found;
}

/// Numbers that follow the document's name in `text`: "2.3, 3.2", "section 9", "6, fixed interfaces".
std::vector<std::string> cited(const std::string& text) {
  std::vector<std::string> numbers;
  const std::regex citation(R"(docs/equations\.md (?:sections? )?(\d+(?:\.\d+)?(?:, \d+(?:\.\d+)?)*))"),
      number(R"([\d.]+)");
  // Tried where the name stands: the expression takes seconds on all the sources.
  for (std::size_t at = text.find(kEquations); at != std::string::npos; at = text.find(kEquations, at + 1)) {
    std::smatch m;
    if (!std::regex_search(text.begin() + static_cast<std::ptrdiff_t>(at), text.end(), m, citation,
                           std::regex_constants::match_continuous))
      continue;
    const std::string list = m[1];
    for (std::sregex_iterator n(list.begin(), list.end(), number), end; n != end; ++n) numbers.push_back(n->str());
  }
  return numbers;
}

TEST(Citations, are_read_with_all_their_numbers) {
  using Numbers = std::vector<std::string>;
  EXPECT_EQ(cited("(docs/equations.md 2.3, 3.2; docs/equations.md section 9)"), (Numbers{"2.3", "3.2", "9"}));
  EXPECT_EQ(cited("(docs/equations.md 6, fixed interfaces)"), (Numbers{"6"}));
  EXPECT_EQ(sections().count("7.35"), 0U);
}

TEST(Citations, of_the_equations_meet_a_section) {
  const std::set<std::string> known = sections();
  ASSERT_GT(known.size(), 30U);
  const std::string old_name = std::string("EQUATIONS") + ".md";
  int count = 0;
  for (const char* folder :
       {"engine", "bodies", "joints", "integrators", "plugins", "examples", "tests", "tools", "docs"})
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      const std::string kind = entry.path().extension();
      if (!entry.is_regular_file() || (kind != ".h" && kind != ".cpp" && kind != ".md" && kind != ".py")) continue;
      if (entry.path().filename() == "citations_test.cpp") continue;
      const std::string text = text_of(entry.path());
      EXPECT_EQ(text.find(old_name), std::string::npos) << entry.path();
      for (const std::string& number : cited(text)) {
        ++count;
        EXPECT_TRUE(known.count(number)) << entry.path() << " cites " << kEquations << " " << number;
      }
    }
  EXPECT_GT(count, 55) << "citations are no longer found";
}

}  // namespace
}  // namespace lithe::test::citations_test
