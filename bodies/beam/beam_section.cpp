#include "bodies/beam/beam_section.h"

#include <numbers>

#include "engine/base/checks.h"
#include "engine/base/dense.h"

namespace lithe {

namespace {

constexpr double kPi = std::numbers::pi;

void check_material(const Material& m) {
  require::positive(m.young, "Young's modulus");
  require::positive(m.density, "density");
  if (!(m.poisson >= 0 && m.poisson <= 0.5))
    throw SceneError("Poisson's ratio is " + std::to_string(m.poisson), "", "give a value from 0 to 0.5");
}

/// Of one material: area, second moments about axes 2 and 3, torsion constant, shear factors along 2 and 3.
BeamSection homogeneous(const Material& m, double area, double I2, double I3, double torsion, double k2, double k3) {
  const double G = m.young / (2 * (1 + m.poisson));
  Vector6 stiffness;
  stiffness << m.young * area, k2 * G * area, k3 * G * area, G * torsion, m.young * I2, m.young * I3;
  return BeamSection::diagonal(stiffness, m.density * area, m.density * Vector3(I2 + I3, I2, I3));
}

/// J = a b³/3 (1 - 192/π⁵ (b/a) Σ tanh(nπa/2b)/n⁵), n = 1, 3, 5 …, a >= b; Σ 1/n⁵ = 31/32 ζ(5).
double torsion_of_rectangle(double a, double b) {
  if (a < b) std::swap(a, b);
  double sum = 31.0 / 32 * 1.0369277551433699;
  for (int n = 1; n < 25; n += 2) sum -= (1 - std::tanh(n * kPi * a / (2 * b))) / std::pow(n, 5);
  return a * b * b * b / 3 * (1 - 192 / std::pow(kPi, 5) * b / a * sum);
}

/// Along the half axis a.
double shear_of_ellipse(double a, double b, double nu) {
  const double aa = a * a, bb = b * b;
  return 12 * (1 + nu) * aa * (3 * aa + bb) / ((40 + 37 * nu) * aa * aa + (16 + 10 * nu) * aa * bb + nu * bb * bb);
}

double shear_of_rectangle(double nu) { return 10 * (1 + nu) / (12 + 11 * nu); }

/// (Γ, K) at a point r beside the origin of (Γ, K): a rigid section's motion.
Matrix6 carried(const Vector3& r) {
  Matrix6 T = Matrix6::Identity();
  T.topRightCorner<3, 3>() = -skew(r);
  return T;
}

}  // namespace

BeamSection BeamSection::diagonal(const Vector6& stiffness, double mass, const Vector3& inertia) {
  BeamSection s;
  s.stiffness = stiffness.asDiagonal();
  s.mass.diagonal() << mass, mass, mass, inertia;
  return s;
}

BeamSection BeamSection::rectangle(double edge_2, double edge_3, const Material& m) {
  require::positive(edge_2, "edge_2 of the rectangle");
  require::positive(edge_3, "edge_3 of the rectangle");
  check_material(m);
  const double A = edge_2 * edge_3, k = shear_of_rectangle(m.poisson);
  return homogeneous(m, A, A * edge_3 * edge_3 / 12, A * edge_2 * edge_2 / 12, torsion_of_rectangle(edge_2, edge_3), k,
                     k);
}

BeamSection BeamSection::circle(double radius, const Material& m) {
  require::positive(radius, "radius of the circle");
  return ellipse(radius, radius, m);
}

BeamSection BeamSection::tube(double inner, double outer, const Material& m) {
  require::positive(inner, "inner radius of the tube");
  require::positive(outer, "outer radius of the tube");
  if (inner >= outer)
    throw SceneError(
        "the tube's inner radius " + std::to_string(inner) + " is not below the outer, " + std::to_string(outer), "",
        "give tube(inner, outer, material)");
  check_material(m);
  const double I = kPi / 4 * (std::pow(outer, 4) - std::pow(inner, 4)), ratio = inner * inner / (outer * outer);
  const double nu = m.poisson, square = (1 + ratio) * (1 + ratio);
  const double k = 6 * (1 + nu) * square / ((7 + 6 * nu) * square + (20 + 12 * nu) * ratio);
  return homogeneous(m, kPi * (outer * outer - inner * inner), I, I, 2 * I, k, k);
}

BeamSection BeamSection::ellipse(double a, double b, const Material& m) {
  require::positive(a, "half_axis_2 of the ellipse");
  require::positive(b, "half_axis_3 of the ellipse");
  check_material(m);
  const double A = kPi * a * b;
  return homogeneous(m, A, A * b * b / 4, A * a * a / 4, A * a * a * b * b / (a * a + b * b),
                     shear_of_ellipse(a, b, m.poisson), shear_of_ellipse(b, a, m.poisson));
}

BeamSection BeamSection::i_beam(const I& size, const Material& m) {
  const auto& [height, width, web, flange] = size;
  require::positive(height, "height of the I");
  require::positive(width, "width of the I");
  require::positive(web, "web of the I");
  require::positive(flange, "flange of the I");
  const double inside = height - 2 * flange;
  if (inside <= 0 || web > width)
    throw SceneError("an I of height " + std::to_string(height) + " and width " + std::to_string(width) +
                         " has no room for its flanges or web",
                     "", "give thicknesses: flange < height / 2, web <= width");
  check_material(m);
  const double flanges = 2 * width * flange, A = flanges + web * inside, nu = m.poisson;
  const double I2 = (width * std::pow(height, 3) - (width - web) * std::pow(inside, 3)) / 12;
  const double I3 = (2 * flange * std::pow(width, 3) + inside * std::pow(web, 3)) / 12;
  const double torsion = (2 * width * std::pow(flange, 3) + inside * std::pow(web, 3)) / 3;
  // Cowper's ratios are those of the middle lines.
  const double h = height - flange, r = flanges / (h * web), n = width / h;
  const double k3 = 10 * (1 + nu) * std::pow(1 + 3 * r, 2) /
                    (12 + 72 * r + 150 * r * r + 90 * r * r * r + nu * (11 + 66 * r + 135 * r * r + 90 * r * r * r) +
                     30 * n * n * (r + r * r) + 5 * nu * n * n * (8 * r + 9 * r * r));
  return homogeneous(m, A, I2, I3, torsion, shear_of_rectangle(nu) * flanges / A, k3);
}

BeamSection BeamSection::moved(double offset_2, double offset_3) const {
  const Matrix6 T = carried({0, offset_2, offset_3});
  BeamSection s = *this;
  s.stiffness = T.transpose() * stiffness * T;
  s.mass = T.transpose() * mass * T;
  return s;
}

BeamSection BeamSection::turned(double angle) const {
  const Matrix3 R = rotation_about({1, 0, 0}, angle);
  Matrix6 T = Matrix6::Zero();
  T.topLeftCorner<3, 3>() = R, T.bottomRightCorner<3, 3>() = R;
  BeamSection s = *this;
  s.stiffness = T * stiffness * T.transpose();
  s.mass = T * mass * T.transpose();
  return s;
}

BeamSection BeamSection::damped(double time) const {
  BeamSection s = *this;
  s.damping.setConstant(time);
  return s;
}

std::array<double, 2> BeamSection::edges(double thinnest) const {
  const Vector3 c = mass_center();
  const Matrix3 inertia = mass.bottomRightCorner<3, 3>() + mass_per_length() * skew(c) * skew(c);
  const auto edge = [&](int about) {  // b²/12 a mass
    return std::max(thinnest, std::sqrt(12 * std::max(0.0, inertia(about, about)) / mass_per_length()));
  };
  return {edge(2), edge(1)};
}

Vector3 BeamSection::mass_center() const {
  // μ c~ stands below the diagonal.
  return Vector3(mass(5, 1), mass(3, 2), mass(4, 0)) / mass(0, 0);
}

void BeamSection::check(const std::string& which) const {
  require::finite(Eigen::Map<const VectorX>(stiffness.data(), 36), "stiffness of " + which);
  require::finite(Eigen::Map<const VectorX>(mass.data(), 36), "mass of " + which);
  const std::string names[] = {"axial",   "shear along 2",   "shear along 3",
                               "torsion", "bending about 2", "bending about 3"};
  for (int i = 0; i < 6; ++i) {
    require::not_negative(damping[i], "damping time (" + names[i] + ") of " + which);
    if (!(stiffness(i, i) > 0))
      throw SceneError("the stiffness of " + which + " in " + names[i] + " is " + std::to_string(stiffness(i, i)), "",
                       "give a value above zero");
  }
  // Entries have different units: compared beside the diagonal.
  const Vector6 size = stiffness.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix6 C = size.asDiagonal() * stiffness * size.asDiagonal();
  if ((C - C.transpose()).cwiseAbs().maxCoeff() > 1e-9)
    throw SceneError("the stiffness of " + which + " is not symmetric", "", "give a symmetric 6 x 6 matrix");
  const double lowest = Eigen::SelfAdjointEigenSolver<MatrixX>(MatrixX(C)).eigenvalues()[0];
  if (lowest < 1e-10)
    throw SceneError("the stiffness of " + which + " is not positive definite: scaled to ones on its diagonal it has " +
                         "the eigenvalue " + std::to_string(lowest),
                     "", "make its couplings smaller than the geometric means of the diagonal");

  require::positive(mass(0, 0), "mass per length of " + which);
  const double mu = mass(0, 0);
  const Vector3 c = mass_center();
  Matrix6 rigid = mass;
  rigid.topLeftCorner<3, 3>() = mu * Matrix3::Identity();
  rigid.bottomLeftCorner<3, 3>() = mu * skew(c);
  rigid.topRightCorner<3, 3>() = -mu * skew(c);
  const double length = c.norm() + std::sqrt(mass.bottomRightCorner<3, 3>().diagonal().cwiseAbs().maxCoeff() / mu);
  if ((mass - rigid).cwiseAbs().maxCoeff() > 1e-9 * mu * std::max(1.0, length))
    throw SceneError("the mass of " + which + " is not that of a section", "",
                     "give [mu E, -mu skew(c); mu skew(c), J] with the mass mu per length and its centre c");
  const Matrix3 J = mass.bottomRightCorner<3, 3>();
  const Matrix3 about_center = J + mu * skew(c) * skew(c);
  const double least =
      Eigen::SelfAdjointEigenSolver<Matrix3>(0.5 * (about_center + about_center.transpose())).eigenvalues()[0];
  if ((J - J.transpose()).cwiseAbs().maxCoeff() > 1e-9 * J.cwiseAbs().maxCoeff() ||
      least < -1e-9 * J.cwiseAbs().maxCoeff())
    throw SceneError("the rotary inertia of " + which + " has the value " + std::to_string(least) +
                         " about its mass centre, or is not symmetric",
                     "", "give a symmetric J about the origin that is at least mu (c·c E - c cᵀ)");
}

BeamSection between(const BeamSection& first, const BeamSection& second, double share) {
  BeamSection s;
  s.stiffness = (1 - share) * first.stiffness + share * second.stiffness;
  s.mass = (1 - share) * first.mass + share * second.mass;
  s.damping = (1 - share) * first.damping + share * second.damping;
  return s;
}

}  // namespace lithe
