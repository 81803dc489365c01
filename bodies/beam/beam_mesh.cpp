#include "bodies/beam/beam_mesh.h"

#include <algorithm>
#include <cmath>

#include "engine/base/checks.h"
#include "engine/base/rotations.h"

namespace lithe {
namespace {

constexpr double kTurn = 1;  // rad, of the longest element

/// Strains that change linearly along each element, from those of its middle and of its neighbours'.
struct Recovered {
  std::vector<double> arcs;              // of the nodes
  std::vector<Vector6> strains, slopes;  // of the elements: in the middle, by arc length
  std::vector<double> turns;             // of the elements, drawn or bent, rad per m
  double energy = 0;

  Recovered(const Beam& beam, const BodyState& state) {
    const int n = beam.element_count();
    for (int i = 0; i <= n; ++i) arcs.push_back(beam.arc(i));
    const auto angle = [](const Matrix3& A, const Matrix3& B) { return rotation_log(A.transpose() * B).norm(); };
    const auto axes = [&](int i) { return rotation_matrix(Eigen::Map<const Vector4>(state.q + 7 * i + 3)); };
    for (int e = 0; e < n; ++e) {
      strains.push_back(beam.strain(state, e));
      energy += beam.element(e).elastic_energy(strains.back());
      turns.push_back(std::max(angle(axes(e), axes(e + 1)), angle(beam.axes(e), beam.axes(e + 1))) / length(e));
    }
    for (int e = 0; e < n; ++e) {
      const int before = std::max(e - 1, 0), after = std::min(e + 1, n - 1);
      slopes.push_back(Vector6::Zero());
      if (before < after) slopes.back() = (strains[after] - strains[before]) / (middle(after) - middle(before));
    }
  }
  double length(int e) const { return arcs[e + 1] - arcs[e]; }
  double middle(int e) const { return 0.5 * (arcs[e] + arcs[e + 1]); }
  double weight(const Beam& beam, int e) const {
    return slopes[e].dot(beam.element(e).section().stiffness * slopes[e]);
  }
};

/// ½ ∫ (ε - mean)ᵀ C (ε - mean) ds between two arc lengths.
double spread(const Beam& beam, const Recovered& r, double from, double to) {
  constexpr double kGauss = 0.57735026918962576;
  Vector6 sum = Vector6::Zero();
  const auto visit = [&](auto&& take) {
    for (int e = beam.element_at(from); e < beam.element_count() && r.arcs[e] < to; ++e) {
      const double low = std::max(from, r.arcs[e]), high = std::min(to, r.arcs[e + 1]);
      for (const double side : {-kGauss, kGauss}) {
        const double arc = 0.5 * (low + high) + 0.5 * side * (high - low);
        take(e, Vector6(r.strains[e] + (arc - r.middle(e)) * r.slopes[e]), 0.5 * (high - low));
      }
    }
  };
  visit([&](int, const Vector6& strain, double ds) { sum += ds * strain; });
  const Vector6 mean = sum / (to - from);
  double energy = 0;
  visit([&](int e, const Vector6& strain, double ds) {
    energy += 0.5 * ds * (strain - mean).dot(beam.element(e).section().stiffness * (strain - mean));
  });
  return energy;
}

/// The beam's stations and those of its sections, and its ends.
std::vector<double> fixed_nodes(const Beam& beam) {
  const double length = beam.length();
  std::vector<double> fixed{0, length};
  const auto add = [&](double arc) {
    if (arc > 0 && arc < length &&
        std::none_of(fixed.begin(), fixed.end(), [&](double s) { return std::abs(s - arc) < 1e-9 * length; }))
      fixed.push_back(arc);
  };
  for (const double arc : beam.parameters().stations) add(arc);
  for (const auto& section : beam.parameters().sections) add(section.arc);
  std::sort(fixed.begin(), fixed.end());
  return fixed;
}

}  // namespace

double energy_error(const Beam& beam, const BodyState& state) {
  const Recovered r(beam, state);
  double error = 0;
  for (int e = 0; e < beam.element_count(); ++e) error += std::pow(r.length(e), 3) * r.weight(beam, e) / 24;
  return r.energy > 0 ? error / r.energy : 0;
}

/// An element of length h has h³ a/24 of the error, a = ε'ᵀ C ε': for a given number the sum is least where h is as
/// a^(-1/3), and then (∫ a^(1/3) ds)³/(24 n²).
BeamMesh coarsened(const Beam& beam, const BodyState& state, double error) {
  require::positive(error, "the error of a beam's mesh");
  const Recovered r(beam, state);
  const int n = beam.element_count();
  double sum = 0;
  for (int e = 0; e < n; ++e) sum += r.length(e) * std::cbrt(r.weight(beam, e));
  const double wanted = r.energy > 0 ? std::sqrt(sum * sum * sum / (24 * error * r.energy)) : 0;
  // Elements that are due up to each node.
  std::vector<double> due{0};
  for (int e = 0; e < n; ++e) {
    const double by_error = sum > 0 ? wanted * std::cbrt(r.weight(beam, e)) / sum : 0;
    due.push_back(due.back() + r.length(e) * std::max(by_error, r.turns[e] / kTurn));
  }
  const auto due_at = [&](double arc) {
    const int e = beam.element_at(arc);
    return due[e] + (arc - r.arcs[e]) / r.length(e) * (due[e + 1] - due[e]);
  };
  const auto arc_of = [&](double count) {
    const auto behind = std::upper_bound(due.begin(), due.end(), count);
    const int e = std::clamp(static_cast<int>(behind - due.begin()) - 1, 0, n - 1);
    return due[e + 1] > due[e] ? r.arcs[e] + (count - due[e]) / (due[e + 1] - due[e]) * r.length(e) : r.arcs[e];
  };
  const std::vector<double> fixed = fixed_nodes(beam);
  BeamMesh mesh;
  double last = 0;
  const auto add = [&](double arc) {
    mesh.error += spread(beam, r, last, arc);
    if (arc < beam.length()) mesh.stations.push_back(arc);
    last = arc;
  };
  for (std::size_t i = 1; i < fixed.size(); ++i) {
    const double from = due_at(fixed[i - 1]), to = due_at(fixed[i]);
    const int count = std::max(1, static_cast<int>(std::ceil(to - from - 1e-9)));
    for (int k = 1; k < count; ++k) add(arc_of(from + (to - from) * k / count));
    add(fixed[i]);
  }
  mesh.error = r.energy > 0 ? mesh.error / r.energy : 0;
  return mesh;
}

}  // namespace lithe
