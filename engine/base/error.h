#pragma once

#include <source_location>
#include <stdexcept>
#include <string>

namespace lithe {

/// Text that remembers where it was written, so that an error raised far below can name the user's line.
struct Located {
  std::string text;
  std::source_location where;
  Located(const char* what, std::source_location here = std::source_location::current())  // NOLINT: implicit on purpose
      : text(what), where(here) {}
  Located(std::string what, std::source_location here = std::source_location::current())  // NOLINT
      : text(std::move(what)), where(here) {}
};

/// A mistake in a scene, a file or an argument: what is wrong, where, and how to fix it.
/// Thrown by the call that detects it; earlier results are kept.
class Error : public std::runtime_error {
 public:
  Error(std::string what, std::string where, std::string fix);

  const std::string& problem() const { return problem_; }  // what is wrong, one sentence
  const std::string& where() const { return where_; }      // file:line, body, joint or coordinate
  const std::string& fix() const { return fix_; }          // what the user can do

 private:
  std::string problem_, where_, fix_;
};

/// The scene cannot be built as drawn: parameters, markers, connectivity, initial conditions.
class SceneError : public Error {
 public:
  using Error::Error;
};
/// A file is missing, truncated or has the wrong content.
class FileError : public Error {
 public:
  using Error::Error;
};
/// Time integration could not continue; the state reached so far is kept.
class SimulationError : public Error {
 public:
  using Error::Error;
};

/// Within a handler: rethrows the current exception as an Error. Lithe's own errors pass unchanged; lack of memory and
/// exceptions of other code become a SimulationError: "`who` threw: ...", with the original nested in it
/// (std::rethrow_if_nested). If memory is too short even for that, std::bad_alloc passes.
[[noreturn]] void rethrow_as_error(const std::string& who, const std::string& where, const std::string& fix);

/// "file.cpp:12", the last path component only, as errors print it.
std::string to_string(const std::source_location& where);

}  // namespace lithe
