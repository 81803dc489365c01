#include "engine/plugin.h"

using namespace lithe;

/// A closed plane curve through points: a periodic cubic spline in x and y over the length of the chords, so that
/// position, tangent and curvature go on smoothly. Points run counter-clockwise; the first is not repeated at the end.
class ClosedSpline {
 public:
  using Vector2 = Eigen::Vector2d;
  struct Point {
    Vector2 at, rate, bend;  // c, c', c''
    double curvature() const { return (rate[0] * bend[1] - rate[1] * bend[0]) / std::pow(rate.norm(), 3); }
  };

  explicit ClosedSpline(const std::vector<double>& xy)
      : points_(Eigen::Map<const Points>(xy.data(), 2, xy.size() / 2)) {
    const int n = count();
    for (int i = 0; i < n; ++i) lengths_.push_back((point(i + 1) - point(i)).norm());
    // Continuous second derivatives m:  h' m' + 2 (h' + h) m + h m⁺ = 6 ((P⁺ - P)/h - (P - P')/h').
    MatrixX A = MatrixX::Zero(n, n);
    Eigen::MatrixX2d right(n, 2);
    for (int i = 0; i < n; ++i) {
      const int before = (i + n - 1) % n, after = (i + 1) % n;
      const double h = lengths_[i], h_before = lengths_[before];
      A(i, before) += h_before;
      A(i, i) += 2 * (h_before + h);
      A(i, after) += h;
      right.row(i) = 6 * ((point(i + 1) - point(i)) / h - (point(i) - point(before)) / h_before);
    }
    bends_ = A.partialPivLu().solve(right).transpose();
  }

  int count() const { return static_cast<int>(points_.cols()); }
  Vector2 point(int i) const { return points_.col((i + count()) % count()); }

  /// The curve at s in [0, length of the chord] behind point i.
  Point evaluate(int i, double s) const {
    const double h = lengths_[i];
    const Vector2 m0 = bends_.col(i), m1 = bends_.col((i + 1) % count()), third = (m1 - m0) / h;
    const Vector2 slope = (point(i + 1) - point(i)) / h - h / 6 * (2 * m0 + m1);
    return {point(i) + s * (slope + s * (0.5 * m0 + s / 6 * third)), slope + s * (m0 + 0.5 * s * third),
            m0 + s * third};
  }

  /// The point of the curve nearest to d, where (c - d)·c' = 0: by Newton from the nearest of the points, kept within
  /// its two chords by bisection.
  Point nearest(const Vector2& d) const {
    Eigen::Index knot;
    (points_.colwise() - d).colwise().squaredNorm().minCoeff(&knot);
    const int before = (static_cast<int>(knot) + count() - 1) % count();
    double low = -lengths_[before], high = lengths_[knot], s = 0;
    for (int k = 0;; ++k) {
      const Point c = s < 0 ? evaluate(before, s + lengths_[before]) : evaluate(static_cast<int>(knot), s);
      const double f = (c.at - d).dot(c.rate), slope = c.rate.squaredNorm() + (c.at - d).dot(c.bend);
      (f > 0 ? high : low) = s;
      double next = slope > 0 ? s - f / slope : low - 1;
      if (!(next >= low && next <= high)) next = 0.5 * (low + high);
      if (std::abs(next - s) <= 1e-15 * (lengths_[before] + lengths_[knot]) || k == 60) return c;
      s = next;
    }
  }

 private:
  using Points = Eigen::Matrix2Xd;
  Points points_, bends_;
  std::vector<double> lengths_;
};

/// Disc cam and roller follower; with radius 0 a knife edge, a point on the curve. The roller's centre, the second
/// marker, keeps its radius ρ from the profile, which lies in the xy plane of the first marker and turns with it:
///   g = δ(d) − ρ,   d = R_Aᵀ (p_B − p_A),   δ: distance from the profile, positive outside
///   ∇δ = n, the outward normal at the nearest point,   ∂²δ = κ/(1 + κδ) t tᵀ,   κ: its curvature, > 0 where convex
///   g̈ = n·(d̈) + κ/(1 + κδ) (t·ḋ)²    (Gilbarg & Trudinger, Elliptic Partial Differential Equations, 14.6)
/// One row, along the normal, without friction; out of the plane the follower is free: guide it with a joint of its
/// own. Contact is kept: its multiplier is minus the pressing force, so a positive one tells that a real follower lifts
/// off.
class CamFollower final : public Joint</*markers=*/2, /*rows=*/1> {
 public:
  struct Parameters {
    std::vector<double> profile;  // x1, y1, x2, y2, … m, counter-clockwise, in the axes of the first marker
    double roller_radius = 0;     // ρ, m
  };
  static constexpr Field<Parameters> kParameters[] = {{"profile", &Parameters::profile},
                                                      {"roller_radius", &Parameters::roller_radius}};

  /// Throws SceneError: fewer than four points, points that coincide or run clockwise, a roller too large for a hollow.
  explicit CamFollower(const Parameters& parameters)
      : radius_(parameters.roller_radius), profile_(checked(parameters.profile)) {
    require::not_negative(radius_, "roller_radius");
    for (int i = 0; i < profile_.count(); ++i)
      if (1 + radius_ * profile_.evaluate(i, 0).curvature() <= 0)
        throw SceneError("the roller does not fit into the hollow of the profile at point " + std::to_string(i + 1), "",
                         "give a roller_radius below that of the hollow");
  }

  void evaluate(double /*time*/, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    // 1. The roller's centre, and its velocity, as seen from the cam.
    const Vector3 D = B.p - A.p, D_dot = B.v - A.v;
    const Vector3 d = A.R.transpose() * D, d_dot = A.R.transpose() * (D_dot - A.w.cross(D));

    // 2. The nearest point of the profile: tangent, outward normal, distance, curvature.
    const ClosedSpline::Point c = profile_.nearest(d.head<2>());
    const Eigen::Vector2d t = c.rate.normalized(), n(t[1], -t[0]);
    const double distance = n.dot(d.head<2>() - c.at), curvature = c.curvature(), slip = t.dot(d_dot.head<2>());

    // 3. The row; d̈ = R_Aᵀ (D̈ − α × D − 2 ω × Ḋ + ω × (ω × D)).
    const Vector3 normal = A.R * Vector3(n[0], n[1], 0);
    const double bias = normal.dot(A.w.cross(A.w.cross(D)) - 2 * A.w.cross(D_dot)) +
                        curvature / (1 + curvature * distance) * slip * slip;
    rows.add(distance - radius_, {Wrench{-normal, -D.cross(normal)}, force(normal)}, bias);
  }

 private:
  static const std::vector<double>& checked(const std::vector<double>& xy) {
    if (xy.size() % 2 != 0 || xy.size() < 8)
      throw SceneError("the profile has " + std::to_string(xy.size()) + " numbers", "",
                       "give at least four points, as x1, y1, x2, y2 …");
    double twice_area = 0;
    for (size_t i = 0; i < xy.size(); i += 2) {
      require::finite(xy[i], "profile");
      require::finite(xy[i + 1], "profile");
      const size_t j = (i + 2) % xy.size();
      twice_area += xy[i] * xy[j + 1] - xy[i + 1] * xy[j];
      if (xy[i] == xy[j] && xy[i + 1] == xy[j + 1])
        throw SceneError("point " + std::to_string(i / 2 + 1) + " of the profile is given twice", "",
                         "give each once: the curve closes by itself");
    }
    if (twice_area <= 0)
      throw SceneError("the profile runs clockwise", "", "list its points counter-clockwise about the z axis");
    return xy;
  }

  const double radius_;
  const ClosedSpline profile_;
};

LITHE_EXPORT_JOINT(CamFollower, "cam_follower")
