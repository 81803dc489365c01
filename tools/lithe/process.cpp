#include "tools/lithe/process.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "engine/base/error.h"

namespace lithe::command {
namespace {

std::vector<char*> argument_pointers(const std::vector<std::string>& command) {
  std::vector<char*> pointers;
  for (const std::string& argument : command) pointers.push_back(const_cast<char*>(argument.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

[[noreturn]] void fail(const std::string& program) {
  throw FileError("cannot be started: " + std::string(std::strerror(errno)), program,
                  "see that the program is there and that memory and processes are left");
}

}  // namespace

std::string find_program(const std::string& name) {
  if (name.find('/') != std::string::npos) return access(name.c_str(), X_OK) == 0 ? name : "";
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "/usr/bin:/bin");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (const std::string full = folder + "/" + name; !name.empty() && access(full.c_str(), X_OK) == 0) return full;
  return "";
}

Finished run_captured(const std::vector<std::string>& command) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) fail(command[0]);
  const auto arguments = argument_pointers(command);
  const pid_t child = fork();
  if (child < 0) fail(command[0]);
  if (child == 0) {
    setenv("LC_ALL", "C", 1);
    dup2(ends[1], STDOUT_FILENO);
    dup2(ends[1], STDERR_FILENO);
    close(ends[0]);
    close(ends[1]);
    execv(arguments[0], arguments.data());
    _exit(127);
  }
  close(ends[1]);
  Finished finished{};
  std::array<char, 4096> buffer{};
  for (ssize_t n; (n = read(ends[0], buffer.data(), buffer.size())) != 0;) {
    if (n > 0) finished.output.append(buffer.data(), static_cast<std::size_t>(n));
    if (n < 0 && errno != EINTR) break;
  }
  close(ends[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  finished.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return finished;
}

void start_detached(const std::vector<std::string>& command) {
  const auto arguments = argument_pointers(command);
  const pid_t child = fork();
  if (child != 0) {
    if (child > 0) waitpid(child, nullptr, 0);  // it ends at once; its own child goes on
    return;
  }
  setsid();
  if (fork() != 0) _exit(0);
  const int nothing = open("/dev/null", O_RDWR);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(nothing, stream);
  if (nice(10) == -1) errno = 0;  // only slower for others
  execv(arguments[0], arguments.data());
  _exit(127);
}

void become(const std::vector<std::string>& command) {
  const auto arguments = argument_pointers(command);
  execv(arguments[0], arguments.data());
}

}  // namespace lithe::command
