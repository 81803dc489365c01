#include "joints/gears/mesh_stiffness.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "engine/base/checks.h"

namespace lithe {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kPhases = 256;
constexpr double kEntry = 0.05;  // of a mesh cycle: within it a pair enters or leaves

std::vector<double> repeated(const std::vector<double>& values, const std::string& what, int pad) {
  const int n = static_cast<int>(values.size());
  if (n == 0 || n == 2 || n == 3)
    throw SceneError(what + " has " + std::to_string(n) + " values", "",
                     "give one, or four or more over a mesh cycle at equal distances");
  std::vector<double> all;
  for (int i = -pad; i <= n + pad; ++i) all.push_back(values[static_cast<std::size_t>(((i % n) + n) % n)]);
  return all;
}

/// So many points before and behind that ends of the spline are not felt.
constexpr int kPad = 40;

std::vector<double> phases(std::size_t values) {
  std::vector<double> x;
  const int n = static_cast<int>(values);
  for (int i = -kPad; i <= n + kPad; ++i) x.push_back(static_cast<double>(i) / n);
  return x;
}

/// A tooth under load, symmetric about its middle line; heights from the 30° section of the root.
struct LoadedTooth {
  double angle;                        // α'
  double height;                       // u
  double depth;                        // t
  double fillet;                       // of the fillet
  std::function<double(double)> half;  // half thickness at a height over the bottom, without fillet

  double thickness(double y) const {
    const double bottom = y + 0.5 * fillet, below = std::max(0.0, fillet - bottom);
    return 2 * (half(bottom) + fillet - std::sqrt(fillet * fillet - below * below));
  }
};

double fillet_radius(const GearDesign& d) {
  return d.module * (d.dedendum - d.addendum) / (1 - std::sin(d.pressure_angle));
}

/// `roll`: length of the line of action from the base circle to the contact.
LoadedTooth loaded_tooth(const GearGeometry& pair, const InvoluteGear& gear, double roll) {
  const double base = std::abs(gear.base_radius), root = std::abs(gear.root_radius), side = gear.teeth < 0 ? -1 : 1;
  const double at = std::atan(roll / base), r = side * base / std::cos(at);
  LoadedTooth tooth;
  tooth.fillet = fillet_radius(pair.design());
  tooth.angle = at - side * pair.tooth_thickness(gear, r) / std::abs(2 * r);
  tooth.height = std::max(0.0, side * (base / std::cos(tooth.angle) - root) - 0.5 * tooth.fillet);
  tooth.depth = base * std::abs(std::tan(at) - std::tan(tooth.angle));
  tooth.half = [&pair, &gear, base, root, side](double y) {
    const double radius = root + side * y, on = std::max(radius, base);
    return radius * pair.tooth_thickness(gear, side * on) / (2 * on);
  };
  return tooth;
}

/// `over`: height of the contact over the datum line.
LoadedTooth loaded_rack_tooth(const GearGeometry& pair, double over) {
  const GearDesign& d = pair.design();
  const double tangent = std::tan(d.pressure_angle), bottom = d.dedendum * d.module;
  const double middle = 0.25 * (kPi * d.module - d.backlash / std::cos(d.pressure_angle));
  LoadedTooth tooth;
  tooth.fillet = fillet_radius(d);
  tooth.angle = d.pressure_angle;
  tooth.half = [=](double y) { return middle - (y - bottom) * tangent; };
  const double half = middle - over * tangent;
  tooth.height = std::max(0.0, over + bottom - half * tangent - 0.5 * tooth.fillet);
  tooth.depth = half / std::cos(tooth.angle);
  return tooth;
}

/// δ b/F of the tooth and its foundation.
double compliance(const LoadedTooth& tooth, const ToothMaterial& m) {
  const double u = tooth.height, nu = m.poisson_ratio, plane = 1 - nu * nu;
  const double slope = std::pow(std::tan(tooth.angle), 2);
  constexpr int kSteps = 64;
  double bending = 0, shear = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double y = u * (i + 0.5) / kSteps, s = tooth.thickness(y);
    bending += (u - y) * (u - y) / (s * s * s) * u / kSteps;
    shear += u / kSteps / s;
  }
  const double foot = u / tooth.thickness(0);
  const double stem = 12 * plane * bending + (2.4 * (1 + nu) + plane * slope) * shear;
  const double foundation = 18 * plane / kPi * foot * foot + 2 * (1 - nu - 2 * nu * nu) * foot +
                            4.8 * plane / kPi * (1 + (1 - nu) / 2.4 * slope);
  return std::pow(std::cos(tooth.angle), 2) / m.youngs_modulus * (stem + foundation);
}

/// Mean of a periodic function over a window of `width` periods about each point.
std::vector<double> averaged(const std::vector<double>& f, double width) {
  const std::size_t n = f.size();
  if (width * static_cast<double>(n) < 1) return f;
  std::vector<double> sum(n + 1, 0);  // ∫ of the polygon through the values
  for (std::size_t i = 0; i < n; ++i) sum[i + 1] = sum[i] + 0.5 * (f[i] + f[(i + 1) % n]) / static_cast<double>(n);
  const auto integral = [&](double x) {
    const double turns = std::floor(x), place = (x - turns) * static_cast<double>(n);
    const std::size_t i = std::min(n - 1, static_cast<std::size_t>(place));
    const double q = place - static_cast<double>(i);
    return turns * sum[n] + sum[i] + (f[i] + 0.5 * q * (f[(i + 1) % n] - f[i])) * q / static_cast<double>(n);
  };
  std::vector<double> mean(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double x = static_cast<double>(i) / static_cast<double>(n);
    mean[i] = (integral(x + 0.5 * width) - integral(x - 0.5 * width)) / width;
  }
  return mean;
}

/// Spur gears whose teeth are those of a helical pair in its normal section.
GearGeometry virtual_spur(const GearGeometry& pair) {
  GearDesign d = pair.design();
  if (d.helix_angle == 0) return pair;
  const double more = 1 / (std::pow(std::cos(pair.base_helix_angle), 2) * std::cos(d.helix_angle));
  d.teeth_A *= more, d.teeth_B *= more;
  d.helix_angle = 0, d.backlash = 0;
  if (!pair.is_rack())
    d.centre_distance.reset();
  else
    d.centre_distance = 0.5 * d.teeth_A * d.module + pair.centre_distance - pair.A.pitch_radius;
  return GearGeometry(d);
}

}  // namespace

MeshCycle::MeshCycle(const std::vector<double>& values, const std::string& what)
    : spline_(phases(std::max<std::size_t>(1, values.size())), repeated(values, what, kPad), what) {}

CubicSpline::Value MeshCycle::operator()(double phase) const { return spline_(phase - std::floor(phase)); }

double tooth_pair_stiffness(const GearGeometry& pair, const ToothMaterial& m, double along) {
  const double sine = std::sin(pair.working_pressure_angle), least = 1e-3 * pair.design().module;
  const double roll_A = std::max(least, pair.A.working_radius * sine + along);
  double curvature = 1 / roll_A;
  const LoadedTooth A = loaded_tooth(pair, pair.A, roll_A);
  LoadedTooth B;
  if (pair.is_rack()) {
    B = loaded_rack_tooth(pair, pair.centre_distance - pair.A.pitch_radius - along * sine);
  } else {
    const double roll_B = pair.B.working_radius * sine - along;  // negative on a ring, whose flanks are hollow
    const double roll = std::copysign(std::max(least, std::abs(roll_B)), roll_B);
    curvature += 1 / roll;
    B = loaded_tooth(pair, pair.B, std::abs(roll));
  }
  const double plane = 1 - m.poisson_ratio * m.poisson_ratio;
  const double half_width_2 = 8 * plane * m.line_load / (kPi * m.youngs_modulus * curvature);
  const double hertz = 2 * plane / (kPi * m.youngs_modulus) *
                       (std::log(4 * A.depth * B.depth / half_width_2) - m.poisson_ratio / (1 - m.poisson_ratio));
  return 1 / (compliance(A, m) + compliance(B, m) + hertz);
}

double iso_single_stiffness(const GearGeometry& pair, const ToothMaterial& material) {
  const GearDesign& d = pair.design();
  const double more = 1 / (std::pow(std::cos(pair.base_helix_angle), 2) * std::cos(d.helix_angle));
  const double i_A = 1 / (more * d.teeth_A), i_B = d.teeth_B > 0 ? 1 / (more * d.teeth_B) : 0;
  const double x_A = d.shift_A, x_B = d.shift_B;
  const double q = 0.04723 + 0.15551 * i_A + 0.25791 * i_B - 0.00635 * x_A - 0.11654 * x_A * i_A - 0.00193 * x_B -
                   0.24188 * x_B * i_B + 0.00529 * x_A * x_A + 0.00182 * x_B * x_B;  // mm µm/N
  const double rack = (1 + 0.5 * (1.2 - d.dedendum)) * (1 - 0.02 * (20 - d.pressure_angle * 180 / kPi));
  return 1e9 * 0.8 / q * rack * std::cos(d.helix_angle) * material.youngs_modulus / 2.06e11;
}

std::vector<double> mesh_stiffness(const GearGeometry& pair, ToothStiffness model, const ToothMaterial& material) {
  require::positive(material.youngs_modulus, "youngs_modulus");
  require::positive(material.line_load, "line_load");
  if (!(material.poisson_ratio >= 0 && material.poisson_ratio < 0.5))
    throw SceneError("poisson_ratio is " + std::to_string(material.poisson_ratio), "", "give one from 0 to below 0.5");
  const double path = pair.approach + pair.recess;
  std::function<double(double)> one_pair;  // N/m² by the place along the path, 0 to 1
  if (model == ToothStiffness::iso_6336) {
    const double c = iso_single_stiffness(pair, material), drop = 0.75 * (1 - 1 / pair.contact_ratio);
    one_pair = [=](double x) { return c * (1 - drop * (2 * x - 1) * (2 * x - 1)); };
  } else {
    one_pair = [&, spur = virtual_spur(pair)](double x) {
      const double along = x * (spur.approach + spur.recess) - spur.approach;
      return std::cos(pair.base_helix_angle) * tooth_pair_stiffness(spur, material, along);
    };
  }
  std::vector<double> k(kPhases, 0);
  for (int i = 0; i < kPhases; ++i) {
    const double at = pair.base_pitch * i / kPhases;
    for (double along = at - pair.base_pitch * std::ceil(pair.contact_ratio + 1); along <= pair.recess;
         along += pair.base_pitch)
      if (along >= -pair.approach) k[static_cast<std::size_t>(i)] += one_pair((along + pair.approach) / path);
  }
  k = averaged(averaged(k, pair.overlap_ratio), kEntry);
  for (double& each : k) each *= pair.design().face_width;
  return k;
}

}  // namespace lithe
