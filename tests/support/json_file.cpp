#include "tests/support/json_file.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace lithe::test {

nlohmann::json parse_json(const std::string& text) { return nlohmann::json::parse(text); }

nlohmann::json read_json(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  try {
    return nlohmann::json::parse(file);
  } catch (const nlohmann::json::exception& problem) {
    throw std::runtime_error(path + ": " + problem.what());
  }
}

}  // namespace lithe::test
