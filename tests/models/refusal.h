#pragma once

#include <string>

#include "engine/base/error.h"
#include "models/draw_model.h"
#include "models/read_model.h"
#include "tests/models/scratch_folder.h"

namespace lithe::test {

/// What reading and drawing a file of this name and text says; nothing if it is accepted.
inline std::string refusal(const std::string& file, const std::string& text) {
  const ScratchFolder folder;
  try {
    const ModelDescription model = read_model(folder.write(file, text));
    SystemGraph graph;
    draw_model(graph, model);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace lithe::test
