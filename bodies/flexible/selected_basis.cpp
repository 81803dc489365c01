#include "bodies/flexible/selected_basis.h"

#include <Eigen/SVD>
#include <cmath>

#include "bodies/flexible/elastic_problem.h"
#include "bodies/flexible/inertia_integrals.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr double kSmallestField = 2e-3;  // of the largest, pairs of modes at equal strain energy

int pair_of(int k, int l) { return l * (l + 1) / 2 + k; }  // k <= l

void check_selection(const ModalBasis& whole, const Fidelity& fidelity) {
  const auto refuse = [&](const std::string& problem, const std::string& fix) {
    throw SceneError(problem, "basis '" + whole.name + "'", fix);
  };
  if (whole.nodal || !whole.diagonal)
    refuse("a part of the modes was asked of a basis that is not of eigenmodes.",
           "make it by make_basis() with a mode count.");
  for (size_t i = 0; i < fidelity.modes.size(); ++i)
    if (fidelity.modes[i] < 0 || fidelity.modes[i] >= whole.mode_count() ||
        (i > 0 && fidelity.modes[i] <= fidelity.modes[i - 1]))
      refuse("mode " + std::to_string(fidelity.modes[i]) + " was selected of " + std::to_string(whole.mode_count()) +
                 ", counted from 0.",
             "name modes in rising order, each once.");
  if (fidelity.deflection == Deflection::exact || fidelity.elements != 0)
    refuse("it is a basis of modes, of one mesh.", "exact and with any number of elements is a SlenderBody.");
  if (fidelity.deflection == Deflection::linear || fidelity.modes.empty()) return;
  if (!whole.deflection)
    refuse("it has no displacements of second order.", "give make_basis() .deflection = Deflection::stiffened.");
  if (fidelity.deflection == Deflection::quadratic && whole.deflection->quartic.size() == 0)
    refuse("it has no strain energy of fourth order.", "give make_basis() .deflection = Deflection::quadratic.");
}

/// The selected pairs' columns, and the principal fields among what does not stay a mode.
std::shared_ptr<const QuadraticDeflection> selected_deflection(const ModalBasis& whole, const Fidelity& fidelity,
                                                               MatrixX& fields) {
  const QuadraticDeflection& all = *whole.deflection;
  const std::vector<int>& modes = fidelity.modes;
  const auto count = static_cast<int>(modes.size()), pairs = count * (count + 1) / 2;
  std::vector<int> columns, rest;
  VectorX scale(pairs);
  for (int l = 0; l < count; ++l)
    for (int k = 0; k <= l; ++k) {
      const int a = modes[static_cast<size_t>(k)], b = modes[static_cast<size_t>(l)];
      scale[pair_of(k, l)] = 1 / std::sqrt(whole.stiffness.coeff(a, a) * whole.stiffness.coeff(b, b));
      columns.push_back(pair_of(a, b));
    }
  for (int i = 0, m = 0; i < whole.mode_count() + all.field_count(); ++i)
    if (m < count && modes[static_cast<size_t>(m)] == i)
      ++m;
    else
      rest.push_back(i);
  const MatrixX others = all.curvature(rest, columns);
  MatrixX principal(others.rows(), 0);
  if (!rest.empty()) {
    const Eigen::JacobiSVD<MatrixX> parts(others * scale.asDiagonal(), Eigen::ComputeThinU);
    const auto kept = (parts.singularValues().array() > kSmallestField * parts.singularValues()[0]).count();
    principal = parts.matrixU().leftCols(kept);
  }
  const Eigen::Index kept = principal.cols();

  fields.conservativeResizeLike(MatrixX::Zero(fields.rows(), count + kept));
  for (size_t i = 0; i < rest.size(); ++i) fields.row(rest[i]).tail(kept) = principal.row(static_cast<Eigen::Index>(i));
  auto out = std::make_shared<QuadraticDeflection>();
  out->curvature.resize(count + kept, pairs);
  out->curvature << all.curvature(modes, columns), principal.transpose() * others;
  if (fidelity.deflection == Deflection::quadratic) out->quartic = all.quartic(columns, columns);
  out->integrals = transformed(all.integrals, fields);
  const MatrixX T = fields.rightCols(kept);
  out->fields = whole.modes * T.topRows(whole.mode_count()) + all.fields * T.bottomRows(all.field_count());
  return out;
}

}  // namespace

InertiaIntegrals transformed(const InertiaIntegrals& all, const MatrixX& T) {
  InertiaIntegrals out = all;
  const Eigen::Index from = T.rows(), to = T.cols();
  out.Ct = all.Ct * T;
  out.J1 = all.J1 * T;
  out.C0 = all.C0 * T;
  out.Mff = T.transpose() * all.Mff * T;
  // Component c of J2_kl and C1_k e_l is a bilinear form of k and l.
  const auto congruent = [&](const MatrixX& stacked, Eigen::Index components) {
    MatrixX result(components * to, to);
    for (Eigen::Index c = 0; c < components; ++c) {
      const auto rows = Eigen::seqN(c, from, components), rows_out = Eigen::seqN(c, to, components);
      const MatrixX form = stacked(rows, Eigen::all);
      result(rows_out, Eigen::all) = T.transpose() * form * T;
    }
    return result;
  };
  out.J2 = congruent(all.J2, 6);
  out.C1 = congruent(all.C1, 3);
  return out;
}

SelectedBasis selected(const ModalBasis& whole, const Fidelity& fidelity) {
  check_selection(whole, fidelity);
  const std::vector<int>& modes = fidelity.modes;
  const auto count = static_cast<Eigen::Index>(modes.size());
  const bool second_order = fidelity.deflection != Deflection::linear && count > 0;
  MatrixX fields = MatrixX::Zero(whole.mode_count() + (whole.deflection ? whole.deflection->field_count() : 0), count);
  for (Eigen::Index k = 0; k < count; ++k) fields(modes[static_cast<size_t>(k)], k) = 1;

  auto part = std::make_shared<ModalBasis>();
  part->name = whole.name;
  part->origin = whole.origin;
  part->rotation = whole.rotation;
  part->node_ids = whole.node_ids;
  part->node_sets = whole.node_sets;
  part->elements = whole.elements;
  part->skin = whole.skin;
  part->nodes = whole.nodes;
  part->rotations = whole.rotations;
  part->nodal_mass = whole.nodal_mass;
  part->modes = whole.modes(Eigen::all, modes);
  const VectorX stiffness = VectorX(whole.stiffness.diagonal())(modes);
  part->stiffness = diagonal_matrix(stiffness);
  part->modal_mass = diagonal_matrix(VectorX::Ones(count));
  if (whole.damping.size() > 0) part->damping = whole.damping(modes, modes);
  part->diagonal = true;
  part->frequencies = whole.frequencies(modes);
  part->free_swing_dropped = whole.free_swing_dropped;
  const InertiaIntegrals& known = whole.integrals;
  part->integrals = transformed(known.mass > 0 ? known : inertia_integrals(whole), fields.topRows(whole.mode_count()));
  if (second_order) part->deflection = selected_deflection(whole, fidelity, fields);
  return {part, fields};
}

}  // namespace lithe
