#pragma once

#include <algorithm>

#include "tools/bench/peers/peer.h"

/// The data of the closed loops, the same for every engine, and their answers.
namespace lithe::bench::peers {

/// How far a point strays from its reference: rows of t, position and velocity, cubic between the rows.
class Path {
 public:
  explicit Path(std::vector<std::vector<double>> rows) : rows_(std::move(rows)) {
    for (const auto& row : rows_)
      if (row.size() != 7) throw std::invalid_argument("a row of a path is t, x, y, z and their rates");
  }
  void compare(double time, const Point& reached) {
    if (rows_.size() < 2) return;
    const auto after = std::lower_bound(rows_.begin() + 1, rows_.end() - 1, time,
                                        [](const auto& row, double t) { return row[0] < t; });
    const std::vector<double>&a = after[-1], &b = *after;
    const double h = b[0] - a[0], s = (time - a[0]) / h, r = 1 - s;
    Point there{};
    for (int k = 1; k <= 3; ++k)
      there[k - 1] =
          r * r * (1 + 2 * s) * a[k] + s * s * (1 + 2 * r) * b[k] + h * s * r * (r * a[3 + k] - s * b[3 + k]);
    const double distance = norm(reached - there);
    if (!(distance <= worst_)) worst_ = distance;  // no number wins too
  }
  /// m; unknown without reference.
  double worst() const { return rows_.empty() ? kUnknown : worst_; }

 private:
  std::vector<std::vector<double>> rows_;
  double worst_ = 0;
};

/// A run of fixed steps, looked at some thousand times: the largest distance of point() from its path, m, and the
/// largest change of energy(), J. Only advance(steps) is timed.
template <class Advance, class PointOf, class EnergyOf>
Outcome follow(const Request& request, Path path, Advance&& advance, PointOf&& point_of, EnergyOf&& energy_of) {
  Outcome outcome;
  outcome.energy_error = 0;
  const double energy = energy_of();
  const long piece = std::max(1L, request.steps / 1000);
  while (outcome.steps < request.steps) {
    const long count = std::min(piece, request.steps - outcome.steps);
    const double started = cpu_seconds();
    advance(count);
    outcome.seconds += cpu_seconds() - started;
    outcome.steps += count;
    outcome.energy_error = std::max(outcome.energy_error, std::abs(energy_of() - energy));
    path.compare(static_cast<double>(outcome.steps) * request.step, point_of());
  }
  outcome.error = path.worst();
  return outcome;
}

/// Andrews' squeezing mechanism (Hairer & Wanner, Solving ODEs II, VII.7; Mazzia & Magherini's test set): seven bodies
/// in a plane, driven by a constant torque. Angles: β, Θ, γ, Φ, δ, Ω, ε; bodies K1 ... K7 in the same order.
namespace andrews {

constexpr double kMass[7] = {.04325, .00365, .02373, .00706, .07050, .00706, .05498};                   // kg
constexpr double kInertia[7] = {2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5};  // kg m^2
constexpr double kA[2] = {-.06934, -.00227}, kB[2] = {-.03635, .03273}, kC[2] = {.014, .072};           // m
constexpr double d = .028, da = .0115, e = .02, ea = .01421, rr = .007, ra = .00092, ss = .035, sa = .01874,
                 sb = .01043, sc = .018, sd = .02, ta = .02308, tb = .00916, u = .04, ua = .01228, ub = .00449,
                 zf = .02, zt = .04, fa = .01421;                          // m, the literature's names
constexpr double kTorque = .033, kStiffness = 4530, kRestLength = .07785;  // N m on K1; N/m and m from D on K3 to C
constexpr double kStart[7] = {-0.0617138900142764496358948458001, 0,
                              0.455279819163070380255912382449,   0.222668390165885884674473185609,
                              0.487364979543842550225598953530,   -0.222668390165885884674473185609,
                              1.23054744454982119249735015568};
/// At 0.03 s, to 19 digits: 128-bit extrapolation of two formulations, relative angles and Cartesian bodies. The vector
/// published with the test set is good to ten.
constexpr double kEnd[7] = {15.81077119515370732, -15.7563710584118386,  0.0408222401196458029, -0.5347301163420795644,
                            0.524409965879954032, 0.5347301163420795644, 1.048080741041937936};

/// Largest relative error of an angle at 0.03 s.
inline double worst_angle(const std::array<double, 7>& angles) {
  double worst = 0;
  for (int i = 0; i < 7; ++i) worst = std::max(worst, std::abs(angles[i] - kEnd[i]) / std::abs(kEnd[i]));
  return worst;
}

}  // namespace andrews

/// N windows in a row: N + 1 uprights, joined at their tops by N couplers, all unit rods; they start upright, the tops
/// at 1 m/s along x. It passes singular (flat) positions.
namespace four_bar {

constexpr double kSpeed = 1;  // m/s

/// Of a rod in the plane, J.
inline double energy(const Rod& rod) {
  return 0.5 * kRodMass * dot(rod.velocity, rod.velocity) + kRodMass * kGravity * rod.center[2] +
         0.5 * kAcross * dot(rod.angular_velocity, rod.angular_velocity);
}

/// Path of the first upright's top: all uprights turn by one angle θ from the vertical,
///   θ'' = κ sin θ,   κ = g ((N + 1)/2 + N) / ((N + 1)/3 + N),
/// here by Runge-Kutta 4 in steps of 0.1 ms, a row every 2 ms: good to ten digits.
inline Path first_top(int windows, double end) {
  const double n = windows, kappa = kGravity / kRodLength * ((n + 1) / 2 + n) / ((n + 1) / 3 + n), h = 1e-4;
  double angle = 0, rate = kSpeed / kRodLength;
  std::vector<std::vector<double>> rows;
  for (long i = 0; i < std::lround(end / h) + 40; ++i) {
    const double c = kRodLength * std::cos(angle), s = kRodLength * std::sin(angle);
    if (i % 20 == 0) rows.push_back({static_cast<double>(i) * h, s, 0, c, c * rate, 0, -s * rate});
    const double a1 = kappa * std::sin(angle), r2 = rate + h / 2 * a1;
    const double a2 = kappa * std::sin(angle + h / 2 * rate), r3 = rate + h / 2 * a2;
    const double a3 = kappa * std::sin(angle + h / 2 * r2), r4 = rate + h * a3;
    const double a4 = kappa * std::sin(angle + h * r3);
    angle += h / 6 * (rate + 2 * r2 + 2 * r3 + r4);
    rate += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return Path(rows);
}

}  // namespace four_bar

/// Bricard's mechanism (IFToMM A04): five unit rods of square section (0.1 m) and the ground, closed by six revolute
/// joints; gravity along -y, from rest. One degree of freedom, and one redundant equation everywhere.
namespace bricard {

constexpr double kPoints[6][3] = {{0, 0, 0}, {1, 0, 0}, {1, -1, 0}, {1, -1, 1}, {0, -1, 1}, {0, 0, 1}};  // m
// Axes of the joints at these points, as drawn: y, z, x, y, z, x.
constexpr double kAlong = 1.0 / 600, kAcross = 1.01 / 12;  // kg m^2

}  // namespace bricard

}  // namespace lithe::bench::peers
