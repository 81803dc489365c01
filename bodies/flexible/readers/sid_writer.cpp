#include <cstdio>
#include <string>
#include <vector>

#include "bodies/flexible/readers/sid.h"
#include "bodies/flexible/readers/sid_inertia.h"
#include "engine/base/error.h"
#include "engine/output/partial_file.h"

namespace lithe {

Matrix3 full_inertia(const Vector6& s) {
  Matrix3 J;
  J << s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2];
  return J;
}

Vector6 packed_inertia(const Matrix3& a) {
  const Matrix3 s = 0.5 * (a + a.transpose());
  return (Vector6() << s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(0, 2), s(1, 2)).finished();
}

MatrixX gyroscopic_of_rotation(const InertiaIntegrals& I) {
  MatrixX Gr(3, 3 * I.mode_count());
  for (int k = 0; k < I.mode_count(); ++k) Gr.middleCols<3>(3 * k) = full_inertia(I.J1.col(k)) - skew(I.C0.col(k));
  return Gr;
}

MatrixX gyroscopic_of_modes(const InertiaIntegrals& I) {
  const int nm = I.mode_count();
  MatrixX Ge(nm, 3 * nm);
  for (int k = 0; k < nm; ++k)
    for (int l = 0; l < nm; ++l)
      Ge.block<1, 3>(l, 3 * k) = (I.C1.block<3, 1>(3 * k, l) - I.C1.block<3, 1>(3 * l, k)).transpose();
  return Ge;
}

MatrixX by_axes(const MatrixX& by_modes) {
  const Eigen::Index nm = by_modes.cols() / 3;
  MatrixX result(by_modes.rows(), by_modes.cols());
  for (Eigen::Index k = 0; k < nm; ++k)
    for (Eigen::Index axis = 0; axis < 3; ++axis) result.col(nm * axis + k) = by_modes.col(3 * k + axis);
  return result;
}

MatrixX by_modes(const MatrixX& by_axes) {
  const Eigen::Index nm = by_axes.cols() / 3;
  MatrixX result(by_axes.rows(), by_axes.cols());
  for (Eigen::Index k = 0; k < nm; ++k)
    for (Eigen::Index axis = 0; axis < 3; ++axis) result.col(3 * k + axis) = by_axes.col(nm * axis + k);
  return result;
}

MatrixX centrifugal(const InertiaIntegrals& I) {
  MatrixX Oe(I.mode_count(), 6);
  for (int c = 0; c < 6; ++c) Oe.col(kOeColumn[c]) = -kOeWeight[c] * I.J1.row(c).transpose();
  return Oe;
}

namespace {

/// Fixed columns, as FEMBS writes them; zero entries are left out.
class SidWriter {
 public:
  explicit SidWriter(int modes) : modes_(modes) {}
  std::string text;

  void line(int indent, const std::string& what) {
    text += std::string(static_cast<size_t>(indent), ' ') + what + "\n";
  }
  void line(int indent, const std::string& what, const std::string& value) {
    std::string left = std::string(static_cast<size_t>(indent), ' ') + what;
    left.resize(std::max<size_t>(left.size() + 1, 48), ' ');
    text += left + "= " + value + "\n";
  }
  void line(int indent, const std::string& what, double value) { line(indent, what, digits(value)); }

  /// m1[k] is the table's derivative with respect to η_k; none: order 0.
  void table(int indent, const std::string& name, int structure, const MatrixX& m0,
             const std::vector<MatrixX>& m1 = {}) {
    line(indent, name);
    const int in = indent + 5;
    line(in, "order", std::to_string(m1.empty() ? 0 : 1));
    line(in, "nrow", std::to_string(m0.rows()));
    line(in, "ncol", std::to_string(m0.cols()));
    line(in, "nq", std::to_string(modes_));
    line(in, "nqn", "0");
    line(in, "structure", std::to_string(structure));
    const auto at = [](auto... index) {
      std::string list;
      ((list += (list.empty() ? " " : ", ") + std::to_string(index)), ...);
      return "(" + list + ")";
    };
    for (Eigen::Index j = 0; structure != 4 && j < m0.cols(); ++j)
      for (Eigen::Index i = 0; i < m0.rows(); ++i)
        if (m0(i, j) != 0) line(in, "m0" + at(i + 1, j + 1), m0(i, j));
    for (Eigen::Index j = 0; j < m0.cols(); ++j)
      for (Eigen::Index i = 0; i < m0.rows(); ++i)
        for (size_t k = 0; k < m1.size(); ++k)
          if (m1[k](i, j) != 0) line(in, "m1" + at(i + 1, static_cast<Eigen::Index>(k) + 1, j + 1), m1[k](i, j));
    line(indent, "end " + name);
  }

 private:
  static std::string digits(double value) {
    char buffer[40];
    std::snprintf(buffer, sizeof buffer, "%.16E", value);
    for (char& c : buffer)
      if (c == 'E') c = 'D';  // FORTRAN's double precision
    return buffer;
  }
  int modes_;
};

void add_sid_node(SidWriter& out, const ModalBasis& basis, int i, const Matrix3X& psi) {
  const Eigen::Index nm = basis.modes.cols();
  const MatrixX phi = basis.modes.middleRows(3 * i, 3);
  out.line(16, "new node", std::to_string(basis.node_ids[static_cast<size_t>(i)]));
  out.line(21, "rframe", "body ref");
  std::vector<MatrixX> along, turning;
  for (Eigen::Index k = 0; k < nm; ++k) {
    along.push_back(phi.col(k));
    turning.push_back(skew(psi.col(k)));
  }
  const bool turns = psi.size() > 0 && psi.cwiseAbs().maxCoeff() > 0;
  out.table(21, "origin", 3, basis.nodes.col(i), along);
  out.table(21, "phi", 3, phi);
  out.table(21, "psi", turns ? 3 : 0, psi);
  out.table(21, "AP", turns ? 3 : 4, Matrix3::Identity(), turns ? turning : std::vector<MatrixX>());
  out.line(16, "end node");
}

void add_sid_tables(SidWriter& out, const ModalBasis& basis) {
  const InertiaIntegrals& I = basis.integrals;
  const int nm = I.mode_count();
  std::vector<MatrixX> first, inertia, rotation, second;
  for (int k = 0; k < nm; ++k) {
    first.push_back(I.Ct.col(k));
    inertia.push_back(full_inertia(I.J1.col(k)));
    rotation.push_back(I.C1.middleRows<3>(3 * k).transpose());
    MatrixX J2(nm, 6);
    for (int c = 0; c < 6; ++c)
      for (int l = 0; l < nm; ++l) J2(l, kOeColumn[c]) = -2 * kOeWeight[c] * I.J2(6 * k + c, l);
    second.push_back(J2);
  }
  const MatrixX K(basis.stiffness), M(I.Mff);
  out.table(11, "mdCM", 3, I.s0, first);
  out.table(11, "J", 2, full_inertia(I.J0), inertia);
  out.table(11, "Ct", 3, I.Ct.transpose());
  out.table(11, "Cr", 3, I.C0.transpose(), rotation);
  out.table(11, "Me", basis.diagonal ? 4 : 2, M);
  out.table(11, "Gr", 3, by_axes(gyroscopic_of_rotation(I)));
  out.table(11, "Ge", 3, by_axes(gyroscopic_of_modes(I)));
  out.table(11, "Oe", 3, centrifugal(I), second);
  out.table(11, "ksigma", 0, MatrixX::Zero(nm, 1));
  out.table(11, "Ke", basis.diagonal ? 1 : 2, K);
  const bool damped = basis.damping.size() > 0;
  out.table(11, "De", damped ? 3 : 0, damped ? basis.damping : MatrixX::Zero(nm, nm));
}

}  // namespace

void write_sid(const std::string& path, const ModalBasis& basis) {
  const int nm = basis.mode_count();
  if (basis.nodal || basis.deflection || !(basis.integrals.mass > 0) || basis.integrals.mode_count() != nm)
    throw SceneError("this basis cannot be written as Standard Input Data.", "basis '" + basis.name + "'",
                     "give an eigenmode basis from make_basis(), of linear deflection, with its inertia integrals.");
  SidWriter out(nm);
  out.line(4, std::to_string(basis.nodes.cols()) + " " + std::to_string(nm) + "    :No. nodes, No. modes:Lithe");
  out.line(1, "part");
  out.line(6, "new modal", "");
  out.line(11, "refmod");
  out.line(16, "mass", basis.integrals.mass);
  out.line(16, "nelastq", std::to_string(nm));
  for (int k = 0; k < nm; ++k) {
    char hertz[40];
    std::snprintf(hertz, sizeof hertz, "%.3f Hz", basis.frequencies.size() == nm ? basis.frequencies[k] : 0.0);
    const bool eigen = basis.diagonal && basis.frequencies.size() == nm;
    out.line(16, "ielastq (" + std::to_string(k + 1) + ")",
             eigen ? "Eigen Mode " + std::to_string(k + 1) + " : " + hertz : "Mode " + std::to_string(k + 1));
  }
  out.line(11, "end refmod");
  out.line(11, "frame");
  const auto n = static_cast<int>(basis.nodes.cols());
  std::vector<Matrix3X> psi(static_cast<size_t>(n), Matrix3X::Zero(3, nm));
  for (size_t k = 0; k < basis.rotations.size(); ++k)
    psi[static_cast<size_t>(basis.rotations[k].node)].row(basis.rotations[k].axis) =
        basis.modes.row(3 * n + static_cast<Eigen::Index>(k));
  for (int i = 0; i < n; ++i) add_sid_node(out, basis, i, psi[static_cast<size_t>(i)]);
  out.line(11, "end frame");
  add_sid_tables(out, basis);
  out.line(6, "end modal");
  out.line(1, "end part");
  PartialFile file(path);
  file.stream() << out.text;
  file.commit();
}

}  // namespace lithe
