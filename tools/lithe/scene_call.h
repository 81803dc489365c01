#pragma once

#include <string>
#include <vector>

#include "tools/lithe/vocabulary.h"

namespace lithe::command {

struct Explanation {
  std::string what, fix;  // fix may be empty
};

/// What is wrong with the call at a place of the source, given the compiler's message: it says that nothing matches,
/// the text of the call says why. Without an explanation of ours, the compiler's message.
Explanation explain_call(const std::string& message, const std::vector<std::string>& source, int line, int column,
                         const Vocabulary& vocabulary);

}  // namespace lithe::command
