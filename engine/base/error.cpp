#include "engine/base/error.h"

#include <exception>
#include <new>

namespace lithe {

Error::Error(std::string what, std::string where, std::string fix)
    : std::runtime_error("error: " + what + "\n  at:   " + where + "\n  fix:  " + fix),
      problem_(std::move(what)),
      where_(std::move(where)),
      fix_(std::move(fix)) {}

void rethrow_as_error(const std::string& who, const std::string& where, const std::string& fix) {
  try {
    throw;
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    std::throw_with_nested(SimulationError("memory ran out in " + who, where,
                                           "free some, or make the scene or what is recorded of it smaller"));
  } catch (const std::exception& error) {
    std::throw_with_nested(SimulationError(who + " threw: " + error.what(), where, fix));
  } catch (...) {
    std::throw_with_nested(SimulationError(who + " threw something that is not a std::exception", where, fix));
  }
}

std::string to_string(const std::source_location& where) {
  const std::string file = where.file_name();
  return file.substr(file.find_last_of('/') + 1) + ":" + std::to_string(where.line());
}

}  // namespace lithe
