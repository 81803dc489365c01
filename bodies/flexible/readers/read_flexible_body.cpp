#include "bodies/flexible/readers/read_flexible_body.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "bodies/flexible/readers/body_formats.h"
#include "bodies/flexible/readers/unit_system.h"
#include "bodies/flexible/reduction.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

FoundBody read_any(const BodyOpening& file, const ImportOptions& options) {
  std::string known;
  for (const BodyFormat& format : body_formats()) {
    known += (known.empty() ? "" : ", ") + std::string(format.name);
    if (!format.recognised(file)) continue;
    FoundBody found = format.read(file, options);
    found.body.format = format.name;
    return found;
  }
  std::string start = file.text.substr(0, std::min<size_t>(file.text.find('\n'), 60));
  for (char& c : start)
    if (c < ' ' || c > '~') c = '?';
  throw FileError("no known format begins like this: '" + start + "'.", file.path.string(),
                  "known are " + known + "; matrices want their deck (.inp) or nodes.csv beside them.");
}

/// Of the reduced body, free: its 6 + nm coordinates at rest (docs/equations.md 2.3).
VectorX free_frequencies(const ModalBasis& basis, int count) {
  const InertiaIntegrals& I = basis.integrals;
  const int nm = basis.mode_count();
  MatrixX M = MatrixX::Zero(6 + nm, 6 + nm), K = M;
  M.topLeftCorner<3, 3>() = I.mass * Matrix3::Identity();
  M.block<3, 3>(3, 0) = skew(I.s0);
  M.block<3, 3>(3, 3) << I.J0[0], I.J0[3], I.J0[4], I.J0[3], I.J0[1], I.J0[5], I.J0[4], I.J0[5], I.J0[2];
  M.bottomLeftCorner(nm, 3) = I.Ct.transpose();
  M.block(6, 3, nm, 3) = I.C0.transpose();
  M.bottomRightCorner(nm, nm) = I.Mff;
  M = MatrixX(M.selfadjointView<Eigen::Lower>());
  K.bottomRightCorner(nm, nm) = MatrixX(basis.stiffness);
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixX> solver(K, M, Eigen::EigenvaluesOnly);
  const int found = std::min(nm, count);
  return solver.eigenvalues().segment(6, found).cwiseMax(0).cwiseSqrt() / (2 * std::numbers::pi);
}

void settle_model(FoundBody& found, const BodyOpening& file, const ImportOptions& options) {
  FiniteElementModel& model = found.model;
  const UnitEvidence evidence = unit_evidence(model);
  const UnitSystem& units = choose_units(options.units, evidence, file.path.string());
  found.body.units = units.name + " (" + units.remark + "): " + figures(evidence, units);
  convert_to_si(model, units);
  found.body.check = require_sound(model);
  const int dofs = model.dof_count(), wanted = std::min(options.frequencies + 6, dofs);
  if (options.frequencies > 0 && wanted > 6) found.body.frequencies = frequencies(model, {}, wanted).tail(wanted - 6);

  auto& notes = found.body.notes;
  notes.push_back(std::to_string(3 * model.node_count()) + " translations and " +
                  std::to_string(model.rotations.size()) + " rotations of nodes");
  if (model.damping.nonZeros() > 0) notes.push_back("a damping matrix came with the model");
  if (found.modes.cols() > 0) notes.push_back(std::to_string(found.modes.cols()) + " mode shapes came with the model");
  found.body.modes = std::move(found.modes);
  found.body.model = std::make_shared<const FiniteElementModel>(std::move(model));
}

void settle_basis(FoundBody& found, const BodyOpening& file, const ImportOptions& options) {
  ModalBasis basis = *found.basis;
  const UnitEvidence evidence = unit_evidence(basis);
  const UnitSystem& units = choose_units(options.units, evidence, file.path.string());
  found.body.units = units.name + " (" + units.remark + "): " + figures(evidence, units);
  convert_to_si(basis, units);
  ModelCheck& check = found.body.check;
  const InertiaIntegrals& I = basis.integrals;
  check.name = basis.name;
  check.nodes = static_cast<int>(basis.nodes.cols());
  check.mass = I.mass;
  check.center = I.s0 / I.mass;
  const Matrix3 c = skew(check.center);
  check.inertia << I.J0[0], I.J0[3], I.J0[4], I.J0[3], I.J0[1], I.J0[5], I.J0[4], I.J0[5], I.J0[2];
  check.inertia += I.mass * c * c;
  check.mass_positive = true;  // the reader has refused others
  found.body.frequencies = free_frequencies(basis, options.frequencies);
  found.body.notes.push_back(std::to_string(basis.mode_count()) + " modes");
  found.body.basis = std::make_shared<const ModalBasis>(std::move(basis));
}

}  // namespace

FlexibleBodyFile read_flexible_body(const std::string& path, const ImportOptions& options) {
  const BodyOpening file = open_body(path);
  FoundBody found = read_any(file, options);
  if (found.basis)
    settle_basis(found, file, options);
  else
    settle_model(found, file, options);
  return std::move(found.body);
}

std::string FlexibleBodyFile::sheet() const {
  const auto row = [](const std::string& name, const std::string& text) {
    std::string left = "  " + name;
    left.resize(std::max<size_t>(left.size() + 1, 28), ' ');
    return left + text + "\n";
  };
  std::string text = format + "\n";
  for (const std::string& file : files) text += row(&file == files.data() ? "files" : "", file);
  text += row("units", units);
  for (const std::string& note : notes) text += row(&note == notes.data() ? "notes" : "", note);
  if (model) {
    text += check.report();
  } else {
    char line[400];
    std::snprintf(line, sizeof line,
                  "reduced body, %d nodes\n"
                  "  mass                      %.6g kg\n"
                  "  centre of mass            %.6g %.6g %.6g m\n"
                  "  inertia about it          xx %.6g  yy %.6g  zz %.6g  xy %.6g  xz %.6g  yz %.6g kg m2\n"
                  "  M positive definite       yes  ok\n",
                  check.nodes, check.mass, check.center[0], check.center[1], check.center[2], check.inertia(0, 0),
                  check.inertia(1, 1), check.inertia(2, 2), check.inertia(0, 1), check.inertia(0, 2),
                  check.inertia(1, 2));
    text += line;
  }
  std::string hertz;
  for (double f : frequencies) {
    char figure[32];
    std::snprintf(figure, sizeof figure, "%.6g ", f);
    hertz += figure;
  }
  return text + row("free frequencies", hertz.empty() ? "none" : hertz + "Hz");
}

}  // namespace lithe
