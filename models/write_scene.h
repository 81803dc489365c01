#pragma once

#include <filesystem>
#include <string>

#include "models/draw_model.h"

namespace lithe {

/// A model as a scene in C++ that runs alike: bodies, joints, springs, couplings of the catalogue, the run and a
/// recorder of the joints' coordinates into results/NAME.csv. Throws SceneError, naming the line of the file, for what
/// acts by a function of an Adams data set (SFORCE, MOTION ...) and for BUSHING, FIELD and BEAM: read_model() runs
/// them.
std::string scene_text(const ModelDescription& model, const DrawnModel::Options& options = {});
/// The same into a file. FileError if it cannot be written.
void write_scene(const ModelDescription& model, const std::filesystem::path& path,
                 const DrawnModel::Options& options = {});

}  // namespace lithe
