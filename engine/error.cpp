#include "engine/error.h"

namespace lithe {

Error::Error(std::string what, std::string where, std::string mend)
    : std::runtime_error("error: " + what + "\n  at:   " + where + "\n  mend: " + mend),
      problem_(std::move(what)),
      where_(std::move(where)),
      mend_(std::move(mend)) {}

std::string to_string(const std::source_location& where) {
  const std::string file = where.file_name();
  return file.substr(file.find_last_of('/') + 1) + ":" + std::to_string(where.line());
}

}  // namespace lithe
