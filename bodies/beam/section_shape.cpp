#include "bodies/beam/section_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRim = 1e-9;  // of the size: round-off of a point on the rim
constexpr int kTerms = 200;    // of Saint-Venant's series

SectionStress operator+(const SectionStress& a, const SectionStress& b) {
  return {a.normal + b.normal, a.shear_2 + b.shear_2, a.shear_3 + b.shear_3};
}

/// Shears (along x, along y) of a rectangle |x| <= a, |y| <= b, a <= b, twisted by 1/G a length: ∂φ/∂y and -∂φ/∂x of
///   φ = a² - x² - (32 a²/π³) Σ (-1)^((n-1)/2)/n³ cosh(nπy/2a)/cosh(nπb/2a) cos(nπx/2a),  n odd.
std::array<double, 2> twisted_rectangle(double a, double b, double x, double y) {
  double along_x = 0, along_y = 2 * x;
  for (int i = 0; i < kTerms; ++i) {
    const double n = 2 * i + 1, c = n * kPi / (2 * a), sign = i % 2 == 0 ? 1 : -1;
    // cosh(cy)/cosh(cb) and sinh(cy)/cosh(cb) without overflow.
    const double up = std::exp(c * (std::abs(y) - b)), below = 1 + std::exp(-2 * c * b);
    const double even = up * (1 + std::exp(-2 * c * std::abs(y))) / below;
    const double odd = std::copysign(up * (1 - std::exp(-2 * c * std::abs(y))) / below, y);
    const double size = 16 * a * sign / (kPi * kPi * n * n);
    along_x -= size * odd * std::cos(c * x);
    along_y -= size * even * std::sin(c * x);
  }
  return {along_x, along_y};
}

}  // namespace

double SectionStress::von_mises() const {
  return std::sqrt(normal * normal + 3 * (shear_2 * shear_2 + shear_3 * shear_3));
}

SectionShape::SectionShape(Kind kind, double a, double b, const BeamSection::I& size)
    : kind_(kind), a_(a), b_(b), size_(size) {
  const Matrix6 C = section({1, 0, 1}).stiffness;  // E = 1, G = ½
  area_ = C(0, 0), I2_ = C(4, 4), I3_ = C(5, 5), torsion_constant_ = 2 * C(3, 3);
}

SectionShape SectionShape::rectangle(double edge_2, double edge_3) { return {Kind::rectangle, edge_2, edge_3}; }
SectionShape SectionShape::tube(double inner, double outer) { return {Kind::tube, inner, outer}; }
SectionShape SectionShape::ellipse(double half_axis_2, double half_axis_3) {
  return {Kind::ellipse, half_axis_2, half_axis_3};
}
SectionShape SectionShape::i_beam(const BeamSection::I& size) { return {Kind::i_beam, size.width, size.height, size}; }

BeamSection SectionShape::section(const Material& material) const {
  switch (kind_) {
    case Kind::rectangle:
      return BeamSection::rectangle(a_, b_, material);
    case Kind::ellipse:
      return BeamSection::ellipse(a_, b_, material);
    case Kind::tube:
      return BeamSection::tube(a_, b_, material);
    case Kind::i_beam:
      break;
  }
  return BeamSection::i_beam(size_, material);
}

bool SectionShape::contains(double x_2, double x_3) const {
  const double y = std::abs(x_2), z = std::abs(x_3), slack = 1 + kRim;
  switch (kind_) {
    case Kind::rectangle:
      return y <= slack * a_ / 2 && z <= slack * b_ / 2;
    case Kind::ellipse:
      return std::hypot(y / a_, z / b_) <= slack;
    case Kind::tube:
      return std::hypot(y, z) <= slack * b_ && std::hypot(y, z) >= (1 - kRim) * a_;
    case Kind::i_beam:
      break;
  }
  const bool in_flange = z >= (1 - kRim) * (size_.height / 2 - size_.flange) && y <= slack * size_.width / 2;
  return z <= slack * size_.height / 2 && (in_flange || y <= slack * size_.web / 2);
}

SectionStress SectionShape::torsion(double moment, double x_2, double x_3) const {
  switch (kind_) {
    case Kind::rectangle: {
      const double twist = moment / torsion_constant_;
      if (a_ <= b_) {
        const auto [along_2, along_3] = twisted_rectangle(a_ / 2, b_ / 2, x_2, x_3);
        return {0, twist * along_2, twist * along_3};
      }
      const auto [along_3, along_2] = twisted_rectangle(b_ / 2, a_ / 2, x_3, x_2);
      return {0, -twist * along_2, -twist * along_3};
    }
    case Kind::ellipse: {
      const double scale = 2 * moment / (kPi * a_ * b_);
      return {0, -scale * x_3 / (b_ * b_), scale * x_2 / (a_ * a_)};
    }
    case Kind::tube:
      return {0, -moment / torsion_constant_ * x_3, moment / torsion_constant_ * x_2};
    case Kind::i_beam:
      break;
  }
  const double slope = 2 * moment / torsion_constant_, inside = size_.height / 2 - size_.flange;
  if (std::abs(x_3) < inside) return {0, 0, slope * x_2};
  return {0, -slope * (x_3 - std::copysign(inside + size_.flange / 2, x_3)), 0};
}

SectionStress SectionShape::shear(double force_2, double force_3, double x_2, double x_3) const {
  switch (kind_) {
    case Kind::rectangle: {
      const double y = 2 * x_2 / a_, z = 2 * x_3 / b_;
      return {0, 1.5 * force_2 / area_ * (1 - y * y), 1.5 * force_3 / area_ * (1 - z * z)};
    }
    case Kind::ellipse: {
      const double along_2 = force_2 / (3 * I3_), along_3 = force_3 / (3 * I2_);
      return {0, along_2 * (a_ * a_ - x_2 * x_2) - along_3 * x_2 * x_3,
              along_3 * (b_ * b_ - x_3 * x_3) - along_2 * x_2 * x_3};
    }
    case Kind::tube: {
      // As in a full circle, and a field without sources, ∇((A + B/ρ²) (F·x)), that keeps it along both rims.
      const double square = x_2 * x_2 + x_3 * x_3, inner = a_ * a_, outer = b_ * b_;
      const double along = (force_2 * x_2 + force_3 * x_3) / (3 * I2_), B = inner * outer / square;
      const double whole = (inner + outer + B) / (3 * I2_), radial = along * (1 + 2 * B / square);
      return {0, whole * force_2 - radial * x_2, whole * force_3 - radial * x_3};
    }
    case Kind::i_beam:
      break;
  }
  const double inside = size_.height / 2 - size_.flange, middle = inside + size_.flange / 2;
  SectionStress stress;
  if (std::abs(x_3) < inside) {
    const double flange = size_.width * size_.flange * middle;
    stress.shear_3 = force_3 / (I2_ * size_.web) * (flange + size_.web / 2 * (inside * inside - x_3 * x_3));
  } else {
    const double y = 2 * x_2 / size_.width;
    stress.shear_2 = 1.5 * force_2 / (2 * size_.width * size_.flange) * (1 - y * y);
    // The flow from both halves of a flange into the web.
    if (std::abs(x_2) > size_.web / 2)
      stress.shear_2 -= std::copysign(1.0, x_2 * x_3) * force_3 / I2_ * middle * (size_.width / 2 - std::abs(x_2));
  }
  return stress;
}

SectionStress SectionShape::stress(const Vector6& resultants, double x_2, double x_3) const {
  if (!contains(x_2, x_3))
    throw SceneError("the point (" + std::to_string(x_2) + ", " + std::to_string(x_3) + ") m is outside the section",
                     "", "give a point of the section, in its axes");
  const Vector6& r = resultants;
  const SectionStress bending{r[0] / area_ + r[4] / I2_ * x_3 - r[5] / I3_ * x_2, 0, 0};
  return bending + torsion(r[3], x_2, x_3) + shear(r[1], r[2], x_2, x_3);
}

std::vector<std::array<double, 2>> SectionShape::outline(int corners) const {
  const double y = a_ / 2, z = b_ / 2;
  std::vector<std::array<double, 2>> rim;
  switch (kind_) {
    case Kind::rectangle:
      return {{y, -z}, {y, z}, {-y, z}, {-y, -z}};
    case Kind::ellipse:
    case Kind::tube:
      if (corners < 3)
        throw SceneError("an outline has " + std::to_string(corners) + " corners", "", "give three or more");
      for (int i = 0; i < corners; ++i) {
        const double angle = 2 * kPi * i / corners;
        rim.push_back({(kind_ == Kind::tube ? b_ : a_) * std::cos(angle), b_ * std::sin(angle)});
      }
      return rim;
    case Kind::i_beam:
      break;
  }
  const double web = size_.web / 2, inside = z - size_.flange;
  return {{y, -z}, {y, -inside}, {web, -inside}, {web, inside},   {y, inside},   {y, z},
          {-y, z}, {-y, inside}, {-web, inside}, {-web, -inside}, {-y, -inside}, {-y, -z}};
}

std::vector<std::array<double, 2>> SectionShape::critical_points() const {
  std::vector<std::array<double, 2>> points;
  switch (kind_) {
    case Kind::rectangle:
      for (const double y : {-0.5, -0.25, 0.0, 0.25, 0.5})
        for (const double z : {-0.5, -0.25, 0.0, 0.25, 0.5}) points.push_back({y * a_, z * b_});
      return points;
    case Kind::ellipse:
    case Kind::tube:
      points.push_back({kind_ == Kind::tube ? a_ : 0, 0});
      for (int i = 0; i < 32; ++i) {
        const double angle = 2 * kPi * i / 32;
        points.push_back({(kind_ == Kind::tube ? b_ : a_) * std::cos(angle), b_ * std::sin(angle)});
      }
      return points;
    case Kind::i_beam:
      break;
  }
  const double inside = size_.height / 2 - size_.flange;
  for (const double side : {-1.0, 1.0}) {
    for (const double y : {-0.5, 0.0, 0.5})
      for (const double z : {size_.height / 2, inside}) points.push_back({y * size_.width, side * z});
    for (const double z : {0.0, 0.999999 * inside})
      for (const double y : {-0.5, 0.5}) points.push_back({y * size_.web, side * z});
  }
  return points;
}

double SectionShape::largest_von_mises(const Vector6& resultants) const {
  double largest = 0;
  for (const auto& [x_2, x_3] : critical_points())
    largest = std::max(largest, stress(resultants, x_2, x_3).von_mises());
  return largest;
}

}  // namespace lithe
