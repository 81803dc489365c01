#include "engine/base/resource.h"

#include <cctype>
#include <string_view>

#include "engine/base/error.h"

namespace lithe {
namespace {

thread_local const std::filesystem::path* current = nullptr;

}  // namespace

std::filesystem::path resource(const std::string& path) {
  const std::filesystem::path plain = std::filesystem::path(path).lexically_normal();
  if (path.empty() || plain.is_absolute() || *plain.begin() == "..")
    throw SceneError("the resource '" + path + "' is not below the folder that the program runs in", "resource()",
                     "give a path that an FMU can have: relative, without leading ..");
  return current ? *current / plain : plain;
}

ResourceFolder::ResourceFolder(std::filesystem::path folder) : folder_(std::move(folder)), outer_(current) {
  if (!folder_.empty()) current = &folder_;
}

ResourceFolder::~ResourceFolder() { current = outer_; }

std::filesystem::path ResourceFolder::of_address(const char* address) {
  const std::string_view all = address ? address : "", kind = "file:", host = "localhost";
  if (!all.starts_with(kind)) return {};
  std::string_view coded = all.substr(kind.size());
  if (coded.starts_with("//")) coded.remove_prefix(2);
  if (coded.starts_with(host)) coded.remove_prefix(host.size());
  std::string path;
  for (std::size_t i = 0; i < coded.size(); ++i) {
    const auto digit = [&](std::size_t at) {
      return at < coded.size() && std::isxdigit(static_cast<unsigned char>(coded[at]));
    };
    if (coded[i] == '%' && digit(i + 1) && digit(i + 2)) {
      path += static_cast<char>(std::stoi(std::string(coded.substr(i + 1, 2)), nullptr, 16));
      i += 2;
    } else {
      path += coded[i];
    }
  }
  return path;
}

}  // namespace lithe
