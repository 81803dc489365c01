#pragma once

#include <algorithm>
#include <random>
#include <vector>

#include "engine/cones/cone_problem.h"

namespace lithe::test {

/// Rigid bodies that touch, as a contact problem: velocities of a body are those of its centre and its spin, world
/// axes.
class TouchingBodies {
 public:
  struct Body {
    double mass = 1;
    Vector3 inertia{1, 1, 1};  // along the world's axes
    Vector3 position{0, 0, 0}, velocity{0, 0, 0}, spin{0, 0, 0};
  };
  struct Touch {
    int a = -1, b = -1;  // bodies; -1: the fixed world
    Vector3 point, normal;
    double friction = 0, restitution = 0;
    double rolling = 0, spinning = 0;
    bool moments = false;
    double turned = 0;  // of the axes across, about the normal, rad
  };
  std::vector<Body> bodies;
  std::vector<Touch> touches;

  Vector6 velocity(int body) const {
    Vector6 v;
    v << bodies[body].velocity, bodies[body].spin;
    return v;
  }
  /// Diagonal of a body's mass matrix.
  Vector6 mass(int body) const {
    Vector6 m;
    m << Vector3::Constant(bodies[body].mass), bodies[body].inertia;
    return m;
  }

  ConeProblem problem() const {
    ConeProblem problem;
    for (std::size_t i = 0; i < bodies.size(); ++i) problem.groups.push_back({static_cast<int>(6 * i), 6});
    problem.velocities = static_cast<int>(6 * bodies.size());
    for (const Touch& touch : touches) problem.rows += touch.moments ? 6 : 3;
    problem.free.setZero(problem.rows);
    int row = 0;
    for (const Touch& touch : touches) {
      const int rows = touch.moments ? 6 : 3;
      ConeProblem::Contact contact{
          .row = row, .rows = rows, .friction = touch.friction, .rolling = touch.rolling, .spinning = touch.spinning};
      Matrix3 axes;  // rows: normal, across 1, across 2
      axes.row(0) = touch.normal.normalized();
      const Vector3 across = axes.row(0).transpose().unitOrthogonal();
      const Vector3 other = Vector3(axes.row(0)).cross(across);
      axes.row(1) = std::cos(touch.turned) * across + std::sin(touch.turned) * other;
      axes.row(2) = Vector3(axes.row(0)).cross(Vector3(axes.row(1)));
      for (int k = 0; k < 2; ++k) {
        const int body = k == 0 ? touch.a : touch.b;
        if (body < 0) continue;
        MatrixX H = MatrixX::Zero(rows, 6);
        H.topLeftCorner(3, 3) = axes;
        H.topRightCorner(3, 3) = -axes * skew(touch.point - bodies[body].position);
        if (touch.moments) {
          H.block<2, 3>(3, 3) = axes.bottomRows<2>();
          H.block<1, 3>(5, 3) = axes.row(0);
        }
        if (k == 0) H = -H;
        problem.free.segment(row, rows) += H * velocity(body);
        const MatrixX Y = mass(body).cwiseInverse().asDiagonal() * H.transpose();
        auto& side = contact.sides[k];
        side = {body, 0, 6, static_cast<int>(problem.values.size()), 0};
        problem.values.insert(problem.values.end(), H.data(), H.data() + H.size());
        side.Y = static_cast<int>(problem.values.size());
        problem.values.insert(problem.values.end(), Y.data(), Y.data() + Y.size());
      }
      problem.free[row] *= 1 + (problem.free[row] < 0 ? touch.restitution : 0);  // u_n >= -e u_n⁻
      problem.contacts.push_back(contact);
      row += rows;
    }
    return problem;
  }

  /// Velocities of all bodies after the impulses.
  VectorX after(const ConeProblem& problem, const VectorX& r) const {
    VectorX u, v;
    problem.velocity(r, u, v);
    for (std::size_t i = 0; i < bodies.size(); ++i) v.segment<6>(6 * i) += velocity(static_cast<int>(i));
    return v;
  }
  double kinetic_energy(const VectorX& v) const {
    double sum = 0;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const Vector6 x = v.segment<6>(6 * i);
      sum += 0.5 * x.dot(mass(static_cast<int>(i)).cwiseProduct(x));
    }
    return sum;
  }
  VectorX before() const {
    VectorX v(6 * bodies.size());
    for (std::size_t i = 0; i < bodies.size(); ++i) v.segment<6>(6 * i) = velocity(static_cast<int>(i));
    return v;
  }
};

/// A homogeneous cube of unit edge a, centred at `position`.
inline TouchingBodies::Body cube(double mass, double edge, const Vector3& position, const Vector3& velocity) {
  return {mass, Vector3::Constant(mass * edge * edge / 6), position, velocity};
}

/// Bodies in a heap that fly into each other and into the world; many touches a body: redundant, and jammed.
inline TouchingBodies random_heap(unsigned seed, int most_touches = 30) {
  std::mt19937 generator(seed);
  const auto uniform = [&](double low, double high) {  // the same on every platform, unlike the library's
    return low + (high - low) * (generator() / 4294967296.0);
  };
  const auto vector = [&] { return Vector3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)); };
  TouchingBodies heap;
  const int touches = 1 + static_cast<int>(uniform(0, most_touches));
  const int bodies = 1 + static_cast<int>(uniform(0, touches));
  for (int i = 0; i < bodies; ++i) {
    const double mass = std::pow(10, uniform(-1, 1));
    heap.bodies.push_back({mass, mass * Vector3(uniform(0.1, 0.3), uniform(0.1, 0.3), uniform(0.1, 0.3)), 2 * vector(),
                           vector(), vector()});
  }
  for (int i = 0; i < touches; ++i) {
    const int b = static_cast<int>(uniform(0, bodies));
    int a = static_cast<int>(uniform(-1, bodies));
    if (a == b) a = -1;
    const Vector3 normal = vector().normalized();
    const Vector3 point = heap.bodies[b].position - 0.8 * normal + 0.5 * vector();
    heap.touches.push_back({.a = a, .b = b, .point = point, .normal = normal, .friction = uniform(0, 1.5)});
    if (uniform(0, 1) < 0.1) heap.touches.back().friction = 0;
  }
  return heap;
}

/// How far impulses are from Coulomb's law, told anew and in its own words: impulses in N s, velocities in m/s.
inline double coulomb_error(const ConeProblem& problem, const VectorX& r) {
  const VectorX u = problem.delassus() * r + problem.free;
  double error = 0;
  for (const auto& contact : problem.contacts) {
    const Vector3 p = r.segment<3>(contact.row), w = u.segment<3>(contact.row);
    const double slip = w.tail<2>().norm(), held = p.tail<2>().norm();
    error = std::max({error, -p[0], -w[0], std::min(p[0], w[0]), held - contact.friction * p[0]});
    // Friction against the slip, at its limit; or no slip.
    error = std::max(error, std::min(slip, (slip * p.tail<2>() + contact.friction * p[0] * w.tail<2>()).norm() / slip));
  }
  return error;
}

}  // namespace lithe::test
