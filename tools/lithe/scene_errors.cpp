// Linked into lithe::scene: an error that a scene does not catch is told like every other, and the program ends with
// exit code 1 instead of a core dump. A signal to end (SIGINT, SIGTERM) ends the run that is under way with an error,
// its state kept; where the scene does not catch that one, the exit code is that of shells, 128 + signal.
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "engine/base/error.h"
#include "engine/base/interrupt.h"

namespace lithe {
namespace {

std::terminate_handler previous;

[[noreturn]] void tell_and_end() {
  const auto end = [](const char* message, const char* more) {
    std::fflush(stdout);
    std::fprintf(stderr, "%s%s\n", message, more);
    std::fflush(nullptr);
    const int signal = InterruptGuard::asked();
    std::_Exit(signal != 0 ? 128 + signal : 1);
  };
  if (const std::exception_ptr thrown = std::current_exception()) {
    try {
      std::rethrow_exception(thrown);
    } catch (const Error& error) {  // says what, where and how to fix
      end("", error.what());
    } catch (const std::exception& error) {
      end("error: the scene threw an exception and did not catch it: ", error.what());
    } catch (...) {  // not derived from std::exception: nothing to tell beyond what the previous handler says
    }
  }
  previous();
  std::abort();
}

const bool installed = (previous = std::set_terminate(tell_and_end), true);
const InterruptGuard guard;

}  // namespace
}  // namespace lithe
