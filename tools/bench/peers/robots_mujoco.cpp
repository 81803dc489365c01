// MuJoCo's smooth forward dynamics on a robot on a fixed base, from URDF: kinematics, composite inertia and its factor,
// bias forces, accelerations; no contacts, limits, actuators or sensors. Built and called by tools/bench/robots.py.
#include <mujoco/mujoco.h>

#include "tools/bench/measure.h"

int main(int argument_count, char** words) {
  using namespace lithe::bench;
  return run_program(argument_count, words, [](Arguments& arguments) {
    const std::string file = arguments.text("model", "");
    const int evaluations = arguments.integer("evaluations", 100000), repeats = arguments.integer("repeat", 5);
    arguments.finish();
    char error[1000] = "";
    mjModel* m = mj_loadXML(file.c_str(), nullptr, error, 1000);
    if (!m) throw std::runtime_error(error);
    mjData* d = mj_makeData(m);
    for (int i = 0; i < m->njnt; ++i) {
      const bool slides = m->jnt_type[i] == mjJNT_SLIDE;
      d->qpos[m->jnt_qposadr[i]] = slides ? 0.01 : 0.3;
      d->qvel[m->jnt_dofadr[i]] = slides ? 0.05 : 0.5;
    }
    mj_forward(m, d);
    double least = 1e300;
    for (int r = 0; r < repeats; ++r) {
      const double started = cpu_seconds();
      for (int i = 0; i < evaluations; ++i) {
        mj_kinematics(m, d), mj_comPos(m, d), mj_crb(m, d), mj_factorM(m, d), mj_comVel(m, d);
        mj_rne(m, d, 0, d->qfrc_bias);
        for (int k = 0; k < m->nv; ++k) d->qacc[k] = -d->qfrc_bias[k];
        mj_solveM(m, d, d->qacc, d->qacc, 1);
      }
      least = std::min(least, cpu_seconds() - started);
    }
    JsonLine line;
    line.add("engine", "MuJoCo").add("version", mj_versionString()).add("freedoms", static_cast<int>(m->nv));
    line.add("us_per_acceleration", 1e6 * least / evaluations, 5);
    line.print();
  });
}
