// Piles of rigid bodies by Bullet, by Bullet as an Integrator of the engine, and by the engine's own time stepping:
// writes FOLDER/contact.json and FOLDER/contact_table.md.
//   contact_bench [--out FOLDER] [--repeats 3] [--scene stack|ratio100|spheres|all] [--step 0.001]
#include <filesystem>
#include <fstream>

#include "engine/cones/gauss_seidel.h"
#include "integrators/moreau_jean.h"
#include "tools/bench/measure.h"
#include "tools/contact/bullet_stepper.h"
#include "tools/contact/measure.h"

using namespace lithe;
using namespace lithe::contact_bench;

namespace {

Contender bullet(int sweeps, bool direct = false) {
  return {direct ? "Bullet, Dantzig" : "Bullet, " + std::to_string(sweeps) + " sweeps",
          [=](const Pile& pile, double step) { return plain_bullet(pile, step, sweeps, direct); }};
}
Contender by(const std::string& name, MakeIntegratorBy<const System&> (*make)(double step)) {
  return {name, [=](const Pile& pile, double step) { return lithe_stepper(pile, step, make(step)); }};
}

MakeIntegratorBy<const System&> bullet_stepper(double step) {
  return [=](const System& system) {
    return std::make_unique<BulletStepper>(system, BulletStepper::Parameters{.step = step});
  };
}
MakeIntegratorBy<const System&> moreau_jean(double step) {
  return [=](const System&) { return std::make_unique<MoreauJean>(MoreauJean::Parameters{.step = step}); };
}
/// As much work as Bullet does, and no more.
MakeIntegratorBy<const System&> moreau_jean_in_sweeps(double step) {
  return [=](const System&) {
    return std::make_unique<MoreauJean>(
        MoreauJean::Parameters{.step = step, .contact = {.tolerance = 1e-3, .position_tolerance = 1e-3}},
        std::make_unique<GaussSeidel>(GaussSeidel::Parameters{.sweeps = 10}));
  };
}

}  // namespace

int main(int count, char** words) {
  return bench::run_program(count, words, [](bench::Arguments& arguments) {
    const std::string folder = arguments.text("out", "results/contact"), scene = arguments.text("scene", "all");
    const int repeats = arguments.integer("repeats", 3);
    const double only = arguments.number("step", 0);  // s; 0: both
    arguments.finish();

    std::vector<Measurement> all;
    for (const double step : only > 0 ? std::vector{only} : std::vector{1.0 / 240, 1e-3})
      for (const Pile& pile :
           {stack("stack", 10, 1, 4), stack("ratio100", 10, 100, 4), spheres(1000, step > 2e-3 ? 2 : 1)}) {
        if (scene != "all" && scene != pile.name) continue;
        std::vector<Contender> contenders{bullet(10), bullet(pile.cubes ? 100 : 50)};
        if (pile.cubes) contenders.push_back(bullet(10, true));
        contenders.push_back(by("BulletStepper, 10 sweeps", bullet_stepper));
        contenders.push_back(by("MoreauJean, 10 sweeps", moreau_jean_in_sweeps));
        contenders.push_back(by("MoreauJean", moreau_jean));
        const auto more = measure(pile, step, contenders, repeats);
        all.insert(all.end(), more.begin(), more.end());
      }
    if (all.empty()) throw std::invalid_argument("there is no scene '" + scene + "'");
    std::filesystem::create_directories(folder);
    std::ofstream(folder + "/contact.json") << json_of(all);
    std::ofstream(folder + "/contact_table.md") << table_of(all);
  });
}
