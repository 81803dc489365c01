// S42: the two-node Timoshenko element with full integration is far too stiff: its linear shapes cannot bend without
// shear. A program of its own: the engine takes elements from others.
#include <Eigen/LU>

#include "engine/base/math.h"
#include "tools/stability/lab.h"

namespace lithe::lab {
namespace {

/// Deflection of a cantilever's tip, L/h = 100, over Timoshenko's theory; a load across, ν = 0.3, shear factor 5/6.
double tip(int elements, bool reduced) {
  constexpr double L = 100, EI = 1.0 / 12, GA = 5.0 / 6 / 2.6;  // height, width, E: 1
  const double h = L / elements;
  Eigen::Matrix4d K = Eigen::Matrix4d::Zero();  // (w, θ) of both nodes
  const auto add = [&](double stiffness, const Vector4& row) { K += stiffness * row * row.transpose(); };
  add(EI * h, Vector4(0, -1 / h, 0, 1 / h));
  const double gauss = reduced ? 0 : 1 / std::sqrt(3.0);
  for (double xi : {-gauss, gauss}) add(GA * h / 2, Vector4(-1 / h, -(1 - xi) / 2, 1 / h, -(1 + xi) / 2));
  const int n = 2 * elements;
  MatrixX all = MatrixX::Zero(n + 2, n + 2);
  for (int e = 0; e < elements; ++e) all.block<4, 4>(2 * e, 2 * e) += K;
  const double w = all.bottomRightCorner(n, n).partialPivLu().solve(VectorX::Unit(n, n - 2))[n - 2];
  return w / (L * L * L / (3 * EI) + L / GA);
}

Finding over_meshes(bool reduced, const std::vector<double>& published, const std::string& why) {
  std::vector<Figure> figures;
  const int meshes[] = {64, 16, 4, 1};
  for (int i = 0; i < 4; ++i)
    figures.push_back({"tip over theory, " + std::to_string(meshes[i]) + " elements", tip(meshes[i], reduced),
                       published[i], reduced ? 3 : 2});
  return {judged(figures[0].value - 1, 0.01), figures, why};
}

const Registered scene{{"S42",
                        "shear locking",
                        {{"full integration",
                          [] {
                            return over_meshes(false, {0.56, 0.074, 5.0e-3, 3.1e-4}, "parasitic shear");
                          }},
                         {"reduced integration", [] {
                            return over_meshes(true, {0.99994, 0.9990, 0.984, 0.750}, "");
                          }}}}};

}  // namespace
}  // namespace lithe::lab
