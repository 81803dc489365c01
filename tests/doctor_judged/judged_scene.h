#pragma once

#include <string>
#include <vector>

#include "bodies/rigid_body.h"
#include "engine/study/doctor.h"
#include "integrators/catalogue.h"

/// Scenes that judge the doctor: written from an engineer's errors and habits, without a look at the doctor's rules.
namespace lithe::test {

/// A scene and how it is run.
struct JudgedScene {
  StudyScene scene;
  std::string method = "automatic";  // of standard_methods()
  double setting = 1e-6;
};

/// A scene with one error. The first finding has to be of one of the causes (empty: of any), and its texts have to hold
/// a word of each list: the culprit's name, and what is wrong with it where no cause says that.
struct SeededError {
  JudgedScene judged;
  std::vector<Cause> causes;
  std::vector<std::vector<std::string>> words;
};

inline const Vector3 kO{0, 0, 0}, kUp{0, 0, 1}, kAlong{1, 0, 0}, kAcross{0, 1, 0};

/// Axes whose z is along `z`.
inline Matrix3 axes_of(const Vector3& z) {
  return Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), z).toRotationMatrix();
}

/// A slender rod from A to B, its x axis along it.
inline RigidBody& add_rod(SystemGraph& graph, const std::string& name, const Vector3& A, const Vector3& B,
                          double mass = 1) {
  const Vector3 along = B - A;
  const double across = mass * along.squaredNorm() / 12;
  return graph.add<RigidBody>(
      name, {.mass = mass,
             .inertia = {1e-2 * across, across, across},
             .position = 0.5 * (A + B),
             .orientation = Eigen::Quaterniond::FromTwoVectors(Vector3::UnitX(), along).toRotationMatrix()});
}

/// A joint of two bodies at a point of the world, its z axis along `z` for both.
template <class T, class A, class B>
T& tie(SystemGraph& graph, const std::string& name, A& a, B& b, const Vector3& point, const Vector3& z = kAcross) {
  return graph.add<T>(name, {a.marker_at_world(point, axes_of(z)), b.marker_at_world(point, axes_of(z))});
}

inline Diagnosis examine(const JudgedScene& judged) {
  for (const StudyMethod& method : standard_methods())
    if (method.name == judged.method)
      return diagnose(judged.scene, method, {.setting = judged.setting, .time_limit = 3});
  throw SceneError("no method '" + judged.method + "'", judged.scene.name, "name one of standard_methods()");
}

}  // namespace lithe::test
