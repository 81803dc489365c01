#include "engine/plugin.h"

using namespace lithe;

/// The rattle box (rattle_box.cpp) by its energies alone: a rigid box, the frame at its centre, and a bead on a spring
/// along its x axis, at η from its rest.
class DerivedBox final : public BodyByEnergy<DerivedBox, /*frames=*/1, /*linear=*/1> {
 public:
  struct Parameters {
    double mass = 1, bead_mass = 0.5;  // kg
    Vector3 inertia{0.1, 0.2, 0.15};   // principal, kg m²
    double stiffness = 50, arm = 0.3;  // N/m, m
    Vector3 position{0, 0, 0};
  };
  static constexpr Field<Parameters> kParameters[] = {
      {"mass", &Parameters::mass},       {"bead_mass", &Parameters::bead_mass},
      {"inertia", &Parameters::inertia}, {"stiffness", &Parameters::stiffness},
      {"arm", &Parameters::arm},         {"position", &Parameters::position}};
  explicit DerivedBox(Parameters parameters)
      : BodyByEnergy({parameters.position, Matrix3::Identity(), {}}), p(parameters) {}

  template <class S>
  S kinetic(const Configuration<S>& q, const Motion<S>& m) const {
    const Eigen::Matrix<S, 3, 1> rate(m.eta_dot[0], 0.0, 0.0), v = m.v + q.R * (m.w.cross(bead(q)) + rate);
    return 0.5 * (p.mass * m.v.squaredNorm() + m.w.dot(p.inertia.cast<S>().cwiseProduct(m.w)) +
                  p.bead_mass * v.squaredNorm());
  }
  template <class S>
  S potential(const Configuration<S>& q, const Vector3& gravity) const {
    return 0.5 * p.stiffness * q.eta[0] * q.eta[0] -
           gravity.cast<S>().eval().dot(p.mass * q.p + p.bead_mass * (q.p + q.R * bead(q)));
  }
  template <class S>
  PoseOf<S> marker_pose(int i, const Configuration<S>& q) const {
    const Place& place = places[static_cast<std::size_t>(i)];
    const Eigen::Matrix<S, 3, 1> r = place.on_bead ? bead(q) : Eigen::Matrix<S, 3, 1>(place.at.cast<S>());
    return {q.p + q.R * r, q.R * place.axes.cast<S>()};
  }

  Marker marker(const Point& at = {}, const Matrix3& axes = Matrix3::Identity()) { return add({at.at, axes, false}); }
  Marker node(int, const Matrix3& axes = Matrix3::Identity()) { return add({{0, 0, 0}, axes, true}); }

 private:
  struct Place {
    Vector3 at;
    Matrix3 axes;
    bool on_bead;
  };
  Marker add(const Place& place) {
    places.push_back(place);
    return new_marker();
  }
  template <class S>
  Eigen::Matrix<S, 3, 1> bead(const Configuration<S>& q) const {
    return {p.arm + q.eta[0], 0.0, 0.0};
  }
  const Parameters p;
  std::vector<Place> places;
};

LITHE_EXPORT_BODY(DerivedBox, "derived_box")
