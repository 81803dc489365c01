// S43: bilinear quadrilaterals lock as ν goes to 0.5. A program of its own: the engine takes elements from others.
#include <Eigen/SparseCholesky>

#include "engine/base/math.h"
#include "tools/stability/lab.h"

namespace lithe::lab {
namespace {

using Strain = Eigen::Matrix<double, 3, 8>;
using Stiffness = Eigen::Matrix<double, 8, 8>;

/// Strains (x, y, shear) of the nodal displacements at (ξ, η) of a dx x dy rectangle.
Strain strain(double xi, double eta, double dx, double dy) {
  constexpr double kCorner[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  Strain B = Strain::Zero();
  for (int c = 0; c < 4; ++c) {
    const double x = kCorner[c][0] * (1 + kCorner[c][1] * eta) / (2 * dx),
                 y = kCorner[c][1] * (1 + kCorner[c][0] * xi) / (2 * dy);
    B(0, 2 * c) = B(2, 2 * c + 1) = x;
    B(1, 2 * c + 1) = B(2, 2 * c) = y;
  }
  return B;
}
/// E = 1, plane strain; selective: the volume's part from the element's centre alone.
Stiffness element(double poisson, bool selective, double dx, double dy) {
  const double lame = poisson / ((1 + poisson) * (1 - 2 * poisson)), shear = 0.5 / (1 + poisson),
               g = 1 / std::sqrt(3.0);
  Matrix3 deviator = Vector3(2 * shear, 2 * shear, shear).asDiagonal(), volume = Matrix3::Zero();
  volume.topLeftCorner<2, 2>().setConstant(lame);
  Stiffness K = Stiffness::Zero();
  const auto add = [&](double xi, double eta, const Matrix3& D, double area) {
    const Strain B = strain(xi, eta, dx, dy);
    K += area * B.transpose() * D * B;
  };
  for (double xi : {-g, g})
    for (double eta : {-g, g}) add(xi, eta, selective ? deviator : Matrix3(deviator + volume), dx * dy / 4);
  if (selective) add(0, 0, volume, dx * dy);
  return K;
}

/// Mean deflection of the end of a cantilever 10 : 1 under a load across, over beam theory; 40 x 4 elements.
double tip(double poisson, bool selective) {
  constexpr int nx = 40, ny = 4;
  constexpr double L = 10, H = 1;
  const Stiffness k = element(poisson, selective, L / nx, H / ny);
  const auto node = [](int i, int j) { return (i - 1) * (ny + 1) + j; };  // negative: clamped
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j) {
      const int corners[] = {node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)};
      for (int a = 0; a < 8; ++a)
        for (int b = 0; b < 8; ++b)
          if (corners[a / 2] >= 0 && corners[b / 2] >= 0 && (i > 0 || (a / 2 % 3 != 0 && b / 2 % 3 != 0)))
            entries.emplace_back(2 * corners[a / 2] + a % 2, 2 * corners[b / 2] + b % 2, k(a, b));
    }
  constexpr int n = 2 * nx * (ny + 1);
  Eigen::SparseMatrix<double> K(n, n);
  K.setFromTriplets(entries.begin(), entries.end());
  VectorX f = VectorX::Zero(n);
  for (int j = 0; j <= ny; ++j) f[2 * node(nx, j) + 1] = (j == 0 || j == ny ? 0.5 : 1.0) / ny;
  const VectorX u = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(K).solve(f);
  double mean = 0;
  for (int j = 0; j <= ny; ++j) mean += u[2 * node(nx, j) + 1] / (ny + 1);
  return mean / (L * L * L / 3 * (1 - poisson * poisson) / (H * H * H / 12));
}

Finding over_ratios(bool selective, const std::vector<double>& published, const std::string& why) {
  std::vector<Figure> figures;
  const double ratios[] = {0.4999, 0.3, 0.49, 0.499, 0.49999};
  for (int i = 0; i < 5; ++i) {
    char text[64];
    std::snprintf(text, sizeof text, "tip over beam theory, ν = %g", ratios[i]);
    figures.push_back({text, tip(ratios[i], selective), published[i]});
  }
  return {judged(figures[0].value - 1, 0.02), figures, why};
}

const Registered scene{{"S43",
                        "near-incompressible",
                        {{"full integration",
                          [] {
                            return over_ratios(false, {0.022, 0.968, 0.548, 0.116, 0.011}, "volumetric locking");
                          }},
                         {"selective reduced integration", [] {
                            return over_ratios(true, {1.0028, 0.99987, 1.0033, 1.0028, 1.0027}, "");
                          }}}}};

}  // namespace
}  // namespace lithe::lab
