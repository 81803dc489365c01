#pragma once

#include <mujoco/mujoco.h>

#include <memory>

#include "tools/bench/peers/peer.h"

/// What MuJoCo's two files share.
namespace lithe::bench::peers {

struct DeleteMujoco {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using MujocoModel = std::unique_ptr<mjModel, DeleteMujoco>;
using MujocoData = std::unique_ptr<mjData, DeleteMujoco>;

/// A file of a model: its name and its text.
using MujocoFile = std::pair<std::string, std::string>;

/// The first file is the model, the others are included by it. Throws std::runtime_error with MuJoCo's words.
MujocoModel load_mujoco(const std::vector<MujocoFile>& files);

/// <compiler> and <option>, without contacts: step, integrator, gravity along `down`.
std::string mujoco_options(const Request& request, const std::string& gravity, bool constraints);

/// Advances by `count` steps. Throws std::runtime_error if MuJoCo warns: it starts a lost simulation anew and goes on.
void step_mujoco(const mjModel* model, mjData* data, long count);

Outcome run_mujoco_loop(const Request& request);

}  // namespace lithe::bench::peers
