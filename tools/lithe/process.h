#pragma once

#include <string>
#include <vector>

/// Other programs: the compiler, and the scene itself.
namespace lithe::command {

/// Path of a program that may be run, looked up in PATH if it has no slash; empty if there is none.
std::string find_program(const std::string& name);

struct Finished {
  int exit_code;
  std::string output;  // stdout and stderr
};
/// Runs a program to its end; its messages are plain English ASCII. Throws FileError if it cannot be started.
Finished run_captured(const std::vector<std::string>& command);
/// Starts a program that outlives this one, at low priority and without a terminal.
void start_detached(const std::vector<std::string>& command);
/// Becomes the program. Returns, with errno set, only if that fails.
void become(const std::vector<std::string>& command);

}  // namespace lithe::command
