// The stability laboratory: every scene of scenes/ with its own methods and with every one of the engine; writes
// summary.json, table.md, map.html, and of the scenes' own methods map.svg and .png.
//   stability [--expected expected.json ...] [--out results/stability] [S01 S05 ...]
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/study/study_run.h"
#include "tools/bench/measure.h"
#include "tools/stability/lab.h"
#include "tools/stability/refuted_cells.h"

namespace {

using namespace lithe;

/// "inaccurate: 3.6e-3 m, grows as t^2.00", by scene and method.
using Expected = std::map<std::pair<std::string, std::string>, std::string>;

void read_expected(const std::string& path, Expected& expected) {
  std::ifstream file(path);
  if (!file) throw FileError("the file cannot be read", path, "give the expected.json of the stability laboratory");
  const nlohmann::json table = nlohmann::json::parse(file);
  for (const auto& scene : table.at("scenes"))
    for (const auto& method : scene.at("methods")) {
      std::string text = method.at("outcome");
      if (method.at("value").is_string()) text += ": " + method.at("value").get<std::string>();
      expected[{scene.at("id"), method.at("method")}] = text;
    }
}

int run_laboratory(int argc, char** argv) {
  Expected expected;
  std::string out = "results/stability";
  std::set<std::string> wanted;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--expected" && i + 1 < argc) {
      read_expected(argv[++i], expected);
    } else if (argument == "--out" && i + 1 < argc) {
      out = argv[++i];
    } else {
      wanted.insert(argument);
    }
  }

  StabilityMap own, all;
  const auto tell = [](const StabilityCell& cell, double seconds, const std::string& mark) {
    std::printf("%s  %-62s %-10s %10s  %s; %s  (%.1f s)%s\n", cell.scene.c_str(), cell.method.c_str(),
                to_string(cell.outcome).c_str(), std::isfinite(cell.value) ? short_number(cell.value).c_str() : "-",
                cell.measure.c_str(), cell.more.c_str(), seconds, mark.c_str());
    if (cell.measure.empty()) std::printf("       %s\n", cell.why.c_str());
    std::fflush(stdout);
  };
  int differing = 0;
  for (const lab::Scene& scene : lab::scenes()) {
    if (!wanted.empty() && !wanted.contains(scene.id)) continue;
    for (const lab::Cell& cell : scene.cells) {
      const double begun = bench::wall_seconds();
      StabilityCell result = lab::run(scene, cell);
      const double seconds = bench::wall_seconds() - begun;
      std::string mark;
      if (const auto at = expected.find({scene.id, cell.method}); at != expected.end()) {
        result.expected = at->second;
        if (!result.expected.starts_with(to_string(result.outcome))) {
          const bool refuted = lab::kRefutedCells.contains({scene.id, cell.method});
          mark = refuted ? "  the published outcome is refuted" : "  NOT AS EXPECTED";
          if (!refuted) ++differing;
        }
      }
      tell(result, seconds, mark);
      all.add(result);
      own.add(std::move(result));
    }
    if (!scene.judge) continue;
    for (const StudyMethod& method : lab::methods_of_the_engine()) {
      const double begun = bench::wall_seconds();
      all.add(lab::run(scene, method));
      tell(all.cells().back(), bench::wall_seconds() - begun, "");
    }
  }
  all.write_json(out + "/summary.json");
  all.write_table(out + "/table.md");
  all.write_page(out + "/map.html");
  own.draw(out + "/map");
  std::printf("%zu cells, %d not as expected; %s/summary.json, table.md, map.html, map.svg, map.png\n",
              all.cells().size(), differing, out.c_str());
  return differing == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run_laboratory(argc, argv);
  } catch (const lithe::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
