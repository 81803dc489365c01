#pragma once

#include <vector>

#include "engine/base/math.h"

namespace lithe {

/// The road that a tyre stands on, in the axes of its marker: z up, heights in metres. A tyre sees the plane that
/// touches the road, or stands for it, at one place.
class TyreRoad {
 public:
  struct Plane {
    Vector3 point, normal;
  };
  virtual ~TyreRoad() = default;
  /// Below a wheel with that centre and axle (a unit vector). `forward`: the wheel's heading along x and y, unit.
  virtual Plane plane_below(const Vector3& centre, const Vector3& axle, const Vector3& forward) const = 0;
  /// Throws SceneError where a wheel of that radius cannot follow it.
  virtual void require_passable(double /*radius*/) const {}
};

/// Heights on a grid, between them bicubic (Hermite, slopes by central differences): normals are continuous. Beyond the
/// grid the heights of its edge go on. The wheel touches where the road is closest to its centre within its plane, so
/// that its radial force has a potential.
class TyreTerrain final : public TyreRoad {
 public:
  struct Parameters {
    double x = 0, y = 0;  // of the first height, m
    double spacing_x = 0, spacing_y = 0;
    MatrixX heights{};  // row i at x + i spacing_x, column j at y + j spacing_y
  };
  /// Throws SceneError for fewer than two rows or columns, a spacing that is not positive, a height that is not finite.
  explicit TyreTerrain(Parameters parameters);

  Plane plane_below(const Vector3& centre, const Vector3& axle, const Vector3& forward) const override;
  /// The road's curvature has to stay below 0.9 / radius: sharper roads are for TyreProfile.
  void require_passable(double radius) const override;

  /// Height, and its slopes along x and y.
  struct Height {
    double value, by_x, by_y;
  };
  Height height(double x, double y) const;

 private:
  Parameters p_;
};

/// Heights along x, the same for all y, with edges: curbs, cleats, steps. Two elliptical cams, one behind the other,
/// roll over it; the plane goes through the mean of their heights w with the slope between them (tandem-cam model:
/// Schmeitz 2004; Pacejka 2012, section 10.1). The radial force then has no potential where the road is not flat.
///   Z(x) = max over |ξ| < a of h(x + ξ) - b + b (1 - (|ξ|/a)^c)^(1/c)
///   w = (Z(x + l/2) + Z(x - l/2)) / 2,   tan β = (Z(x + l/2) - Z(x - l/2)) / l
class TyreProfile final : public TyreRoad {
 public:
  struct Parameters {
    std::vector<double> x{}, heights{};  // corners; equal x: a step. Beyond them heights stay.
    double radius = 0.3;                 // of the tyre: a = 1.05 radius, b = 1.1 radius
    double exponent = 1.8;               // c
    double length = 0.1;                 // l between the cams: 0.8 of the contact's length
  };
  /// Throws SceneError for lists of different lengths, x that fall, and numbers that are not finite or not positive.
  explicit TyreProfile(Parameters parameters);

  Plane plane_below(const Vector3& centre, const Vector3& axle, const Vector3& forward) const override;
  /// Z: how high a cam at x stands above the lowest road's.
  double cam_height(double x) const;

 private:
  double contour(double xi) const;

  Parameters p_;
  double a_, b_;
};

}  // namespace lithe
