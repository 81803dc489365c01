// Models of other programs and FMUs: what is accepted fits together, has finite numbers, and its functions can be
// evaluated.
#include <cmath>

#include "engine/base/error.h"
#include "joints/tyre/magic_formula.h"
#include "models/adams/function_value_internal.h"
#include "models/fmu/fmu_contents_internal.h"
#include "models/fmu/fmu_package_internal.h"
#include "models/read_model.h"
#include "models/read_tir.h"
#include "tools/fuzz/targets.h"

namespace lithe::fuzz {
namespace {

struct AnyTime {
  double time() const { return 0.5; }
  double measure(int) const { return 0.25; }
};

void check(const ModelDescription& model) {
  const int links = static_cast<int>(model.links.size()), joints = static_cast<int>(model.joints.size());
  const auto is_link = [&](int i) { return i >= 0 && i < links; };
  demand(is_link(model.root), "the root is no link");
  std::vector<int> parents(model.links.size(), 0);
  for (const ModelLink& link : model.links) {
    demand(std::isfinite(link.mass) && link.mass >= 0, "a mass is not finite or negative");
    demand(link.inertia.allFinite() && link.inertial.position.allFinite(), "an inertia is not finite");
    demand((link.inertial.rotation.transpose() * link.inertial.rotation - Matrix3::Identity()).norm() < 1e-6,
           "axes of an inertia are no rotation");
  }
  for (const ModelJoint& joint : model.joints) {
    demand(is_link(joint.parent) && is_link(joint.child), "a joint joins what is no link");
    demand(joint.axis.allFinite() && joint.origin.position.allFinite(), "a joint has no place");
    demand(!joint.mimic || (joint.mimic->leader >= 0 && joint.mimic->leader < joints), "a follower has no leader");
    if (!joint.closes_loop && joint.type != ModelJoint::Type::other) ++parents[static_cast<std::size_t>(joint.child)];
  }
  if (!model.adams)
    for (int i = 0; i < links; ++i)
      demand(parents[static_cast<std::size_t>(i)] == (i == model.root ? 0 : 1), "the tree is none");
  demand(!model.sheet().empty() && !model.table().empty(), "there is no sheet");
}

void urdf(std::string_view input, const std::filesystem::path& folder) {
  check(read_urdf(file_of(input, folder, "model.urdf")));
}
void sdf(std::string_view input, const std::filesystem::path& folder) {
  check(read_sdf(file_of(input, folder, "model.sdf")));
}
void mjcf(std::string_view input, const std::filesystem::path& folder) {
  check(read_mjcf(file_of(input, folder, "model.xml")));
}
void adams(std::string_view input, const std::filesystem::path& folder) {
  const ModelDescription model = read_adams(file_of(input, folder, "model.adm"));
  check(model);
  const AnyTime now;
  for (const auto& variable : model.adams->variables) lithe::adams::Value<double, AnyTime>(variable.what, now)();
  for (const auto& motion : model.adams->motions) lithe::adams::Value<double, AnyTime>(motion.what.function, now)();
}

void check(const FmuContents& fmu) {
  demand(fmu.version == 2 || fmu.version == 3, "the version is none");
  demand(!fmu.identifier.empty() && fmu.identifier.find('/') == std::string::npos, "the identifier is no name");
  demand(std::isfinite(fmu.default_step), "the step is not finite");
  demand(fmu.states.size() == fmu.derivatives.size() && fmu.state_count >= 0 && fmu.indicator_count >= 0,
         "states and derivatives are not pairs");
  for (const ImportedVariable& v : fmu.variables) {
    demand(v.size >= 0 && (v.array || v.size == 1), "a size is none");
    demand(v.starts.size() <= 1 || v.starts.size() == static_cast<std::size_t>(v.size), "starts do not fit");
    for (int i = 0; i < v.size; ++i) demand(std::isfinite(v.start(i)), "a start is not finite");
  }
}

/// The description of an FMU, for each kind: refused if it is for both.
void fmu(std::string_view input, const std::filesystem::path& folder) {
  const std::string path = file_of(input, folder, "modelDescription.xml");
  bool taken = false;
  for (const FmuKind kind : {FmuKind::co_simulation, FmuKind::model_exchange}) try {
      check(read_fmu_contents(path, kind));
      taken = true;
    } catch (const FileError&) {
      if (kind == FmuKind::model_exchange && !taken) throw;
    }
}

/// Its archive: files and folders alone.
void fmu_package(std::string_view input, const std::filesystem::path& folder) {
  const FmuPackage package(file_of(input, folder, "model.fmu"));
  for (const auto& entry : std::filesystem::recursive_directory_iterator(package.folder()))
    demand(!entry.is_symlink() && (entry.is_regular_file() || entry.is_directory()), "a link was unpacked");
}

/// A tyre that is accepted by its formula too has finite forces.
void tir(std::string_view input, const std::filesystem::path& folder) {
  const TyreCoefficients read = read_tir(file_of(input, folder, "tyre.tir"));
  try {
    const auto force = MagicFormula(read).at({.load = read.fnomin, .speed = read.longvl});
    demand(std::isfinite(force.Fx + force.Fy + force.Mx + force.My + force.Mz), "a force is not finite");
  } catch (const SceneError&) {  // figures of no tyre
  }
}

}  // namespace

std::vector<Target> model_targets() {
  return {{"urdf", urdf}, {"sdf", sdf}, {"mjcf", mjcf}, {"adams", adams}, {"fmu", fmu}, {"fmu_package", fmu_package},
          {"tir", tir}};
}

}  // namespace lithe::fuzz
