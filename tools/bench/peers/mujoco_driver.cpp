// MuJoCo on the chains; on the loops in mujoco_loops.cpp.
//   chain        joint coordinates, sparse LᵀDL of the mass matrix, which is dense for a chain: O(N³) a step
//   stiff_chain  free bodies; the bushings are its passive forces, so rk4 sees them at every stage
// euler is semi-implicit, implicit takes the velocities' derivatives along: both are of order 1.
#include <algorithm>
#include <cstring>

#include "tools/bench/peers/mujoco.h"

namespace lithe::bench::peers {

namespace {

std::string warning;  // MuJoCo's first

constexpr int kRodsInFile = 80;  // the parser refuses a hundred nested levels: the rest is included by the innermost

std::string file_name(int first) { return "rods" + std::to_string(first) + ".xml"; }

std::string inertia_of_rod(double center) {
  std::ostringstream xml;
  xml.precision(17);
  xml << "<inertial pos='" << center << " 0 0' mass='" << kRodMass << "' diaginertia='" << kAlong << ' ' << kAcross
      << ' ' << kAcross << "'/>";
  return xml.str();
}

std::string nested_rods(const Request& request, int first) {
  const int last = std::min(request.count, first + kRodsInFile);
  const std::string joint = request.spherical() ? "<joint type='ball'/>" : "<joint type='hinge' axis='0 1 0'/>";
  std::ostringstream xml;
  for (int i = first; i < last; ++i)
    xml << "<body pos='" << (i > 0 ? kRodLength : 0) << " 0 0'>" << joint << inertia_of_rod(kRodLength / 2);
  if (last < request.count) xml << "<include file='" << file_name(last) << "'/>";
  for (int i = first; i < last; ++i) xml << "</body>";
  return xml.str();
}

std::string free_rods(const Request& request) {
  std::ostringstream xml;
  for (int i = 0; i < request.count; ++i)
    xml << "<body pos='" << (i + 0.5) * kRodLength << " 0 0'><freejoint/>" << inertia_of_rod(0) << "</body>";
  return xml.str();
}

std::vector<MujocoFile> chain_files(const Request& request) {
  const bool stiff = request.problem == "stiff_chain";
  std::ostringstream gravity;
  gravity << "0 0 " << -kGravity;
  std::vector<MujocoFile> files;
  files.emplace_back("world.xml", "<mujoco>" + mujoco_options(request, gravity.str(), false) + "<worldbody>" +
                                      (stiff ? free_rods(request) : nested_rods(request, 0)) + "</worldbody></mujoco>");
  for (int first = kRodsInFile; !stiff && first < request.count; first += kRodsInFile)
    files.emplace_back(file_name(first), "<mujocoinclude>" + nested_rods(request, first) + "</mujocoinclude>");
  return files;
}

/// Of body `id`; body 0 is the world.
Rod read_rod(const mjModel* model, const mjData* data, int id) {
  mjtNum twist[6];  // angular, then linear: world axes, at the centre of mass
  mj_objectVelocity(model, data, mjOBJ_BODY, id, twist, 0);
  const mjtNum *p = data->xipos + 3 * id, *R = data->xmat + 9 * id;
  return {{p[0], p[1], p[2]}, {R[0], R[3], R[6]}, {twist[3], twist[4], twist[5]}, {twist[0], twist[1], twist[2]}};
}

/// A free body's coordinates: velocity in world axes, angular velocity in its own; its frame is at the centre of mass.
void add_bushing_forces(const mjModel* model, mjData* data) {
  const auto free_rod = [&](int id) {
    const mjtNum *p = data->xipos + 3 * id, *R = data->xmat + 9 * id, *v = data->qvel + 6 * (id - 1);
    mjtNum spin[3];
    mju_rotVecMat(spin, v + 3, R);
    return Rod{{p[0], p[1], p[2]}, {R[0], R[3], R[6]}, {v[0], v[1], v[2]}, {spin[0], spin[1], spin[2]}};
  };
  const auto push = [&](int id, const Point& center, const Point& force, const Point& at) {
    mjtNum* f = data->qfrc_passive + 6 * (id - 1);
    const Point torque = cross(at - center, force);
    mjtNum own[3];
    mju_rotVecMatT(own, torque.data(), data->xmat + 9 * id);
    for (int k = 0; k < 3; ++k) {
      f[k] += force[k];
      f[3 + k] += own[k];
    }
  };
  Rod before{};
  for (int id = 1; id < model->nbody; ++id) {
    const Rod rod = free_rod(id);
    const Point force = bushing_force(id > 1 ? &before : nullptr, rod), at = rod.inboard();
    push(id, rod.center, force, at);
    if (id > 1) push(id - 1, before.center, -1 * force, at);
    before = rod;
  }
}

Outcome run_chain(const Request& request) {
  const MujocoModel model = load_mujoco(chain_files(request));
  const MujocoData data(mj_makeData(model.get()));
  Outcome outcome;
  outcome.steps = request.steps;
  const double started = cpu_seconds();
  step_mujoco(model.get(), data.get(), request.steps);
  outcome.seconds = cpu_seconds() - started;
  mj_forward(model.get(), data.get());
  std::vector<Rod> rods;
  for (int id = 1; id < model->nbody; ++id) rods.push_back(read_rod(model.get(), data.get(), id));
  request.judge(rods, outcome);
  return outcome;
}

}  // namespace

MujocoModel load_mujoco(const std::vector<MujocoFile>& files) {
  const auto folder = std::make_unique<mjVFS>();
  mj_defaultVFS(folder.get());
  for (const auto& [name, text] : files) {
    mj_makeEmptyFileVFS(folder.get(), name.c_str(), static_cast<int>(text.size()));
    std::memcpy(folder->filedata[folder->nfile - 1], text.data(), text.size());
  }
  char error[1000] = "";
  MujocoModel model(mj_loadXML(files.front().first.c_str(), folder.get(), error, sizeof error));
  mj_deleteVFS(folder.get());
  if (!model) throw std::runtime_error(std::string("MuJoCo: ") + error);
  return model;
}

std::string mujoco_options(const Request& request, const std::string& gravity, bool constraints) {
  const std::string integrator = request.method == "rk4" ? "RK4" : request.method == "euler" ? "Euler" : "implicit";
  std::ostringstream xml;
  xml.precision(17);
  xml << "<compiler coordinate='local' angle='radian' inertiafromgeom='false'/><option timestep='" << request.step
      << "' gravity='" << gravity << "' integrator='" << integrator << "'><flag contact='disable' constraint='"
      << (constraints ? "enable" : "disable") << "' sensor='disable'/></option>";
  return xml.str();
}

void step_mujoco(const mjModel* model, mjData* data, long count) {
  mju_user_warning = [](const char* text) {
    if (warning.empty()) warning = text;
  };
  for (long i = 0; i < count; ++i) mj_step(model, data);
  if (!warning.empty()) throw std::runtime_error("MuJoCo: " + warning);
}

}  // namespace lithe::bench::peers

int main(int argument_count, char** words) {
  using namespace lithe::bench;
  return run_program(argument_count, words, [](Arguments& arguments) {
    const peers::Request request(arguments, {"mujoco",
                                             mj_versionString(),
                                             {"chain", "stiff_chain", "andrews", "four_bar", "bricard"},
                                             {"rk4", "euler", "implicit"}});
    arguments.finish();
    if (request.problem == "stiff_chain") mjcb_passive = peers::add_bushing_forces;
    request.print_json(peers::cheapest_of(request.repeats, [&] {
      return request.is_chain() ? peers::run_chain(request) : peers::run_mujoco_loop(request);
    }));
  });
}
