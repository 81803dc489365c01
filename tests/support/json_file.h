#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

/// JSON read once for all tests: its parser costs each source that has it one to two seconds.
namespace lithe::test {

nlohmann::json parse_json(const std::string& text);
/// Throws std::runtime_error, which names the file, if it cannot be read or is not JSON.
nlohmann::json read_json(const std::string& path);

}  // namespace lithe::test
