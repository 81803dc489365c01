// oracle_check DIR: compares the engine with every *.json case in DIR, prints a line a case, exits 1 if any is off.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <vector>

#include "tests/support/oracle.h"

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  if (argc != 2 || !fs::is_directory(argv[1])) {
    std::fprintf(stderr, "usage: oracle_check DIR   (a folder of oracle cases, *.json)\n");
    return 2;
  }
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(argv[1]))
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  int off = files.empty() ? 1 : 0;
  if (files.empty()) std::fprintf(stderr, "no *.json in %s\n", argv[1]);
  for (const fs::path& file : files) {
    std::string name = file.stem().string();
    try {
      std::ifstream in(file);
      const auto data = nlohmann::json::parse(in);
      name = data.value("name", name);
      const auto findings = lithe::oracle::check_case(data);
      const double bound = lithe::oracle::bound(data);
      const auto worst = std::max_element(findings.worst.begin(), findings.worst.end(),
                                          [](const auto& a, const auto& b) { return a.second < b.second; });
      const bool good = findings.largest() <= bound && !findings.worst.empty();
      std::printf("%-26s %3zu quantities, worst %.1e (%s)%s%s\n", name.c_str(), findings.worst.size(),
                  findings.largest(), worst == findings.worst.end() ? "none" : worst->first.c_str(),
                  good ? "" : "  OFF", findings.note.empty() ? "" : ("; " + findings.note).c_str());
      off += !good;
      if (!good)
        for (const auto& [quantity, error] : findings.worst)
          if (!(error <= bound)) std::printf("    %s: %.2e > %.0e\n", quantity.c_str(), error, bound);
    } catch (const std::exception& error) {
      std::printf("%-26s FAILED: %s\n", name.c_str(), error.what());
      ++off;
    }
  }
  return off ? 1 : 0;
}
