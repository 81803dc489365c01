#include "bodies/flexible/readers/sid.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <set>

#include "bodies/flexible/readers/sid_inertia.h"
#include "bodies/flexible/readers/sid_table.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr double kContradiction = 2e-2;  // of the largest entry: refused
constexpr double kDigits = 1e-9;         // tables of twelve digits agree so far
constexpr double kOffDiagonal = 1e-8;    // of √(K_ii K_jj): rounding of a diagonal matrix
constexpr int kMostModes = 1000;

std::string two_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", value);
  return text;
}

/// J may be 3 x 3 or its six entries.
Vector6 inertia_of(const MatrixX& table) {
  return table.rows() == 3 ? packed_inertia(Matrix3(table)) : Vector6(table.col(0));
}

class SidReader {
 public:
  explicit SidReader(const std::string& path) : path_(path), file_(path) {}

  SidBody read() {
    basis_ = std::make_shared<ModalBasis>();
    basis_->name = path_;
    read_header();
    expect("part");
    expect("new modal");
    read_modes();
    read_nodes();
    read_tables();
    settle_inertia();
    settle_elasticity();
    require_positive();
    body_.basis = basis_;
    return std::move(body_);
  }

 private:
  [[noreturn]] void refuse(const std::string& problem, int line, const std::string& fix) const {
    throw FileError(problem, path_ + (line > 0 ? ":" + std::to_string(line) : ""), fix);
  }
  void expect(const std::string& key) {
    if (file_.next().key != key)
      file_.fail("'" + file_.line().key.substr(0, 40) + "' where '" + key + "' should stand.");
  }
  void note(const std::string& text) { body_.notes.push_back(text); }

  /// "    6  11    :No. nodes, No. modes ..."
  void read_header() {
    TextFile& text = file_.text();
    const bool found = text.next();
    const auto& words = text.words();
    if (!found || words.size() < 2) file_.fail("the first line does not count nodes and modes.");
    const auto count = [&](std::string_view word) {
      return text.integer(word.substr(0, word.find(':')), "number of nodes or modes");
    };
    nodes_ = count(words[0]);
    modes_ = count(words[1]);
    if (nodes_ < 1 || modes_ < 0 || modes_ > kMostModes)
      file_.fail("a body of " + std::to_string(nodes_) + " nodes and " + std::to_string(modes_) + " modes.");
  }

  void read_modes() {
    expect("refmod");
    if (file_.next().key != "mass") file_.fail("'mass = ' should stand here.");
    basis_->integrals.mass = file_.number(file_.line().value, "mass");
    file_.integer_of("nelastq", modes_, modes_);
    for (int k = 1; k <= modes_; ++k) {
      const SidLine& line = file_.next();
      if (line.key != "ielastq" || line.indices != std::vector<int>{k})
        file_.fail("the name of mode " + std::to_string(k) + ", ielastq(" + std::to_string(k) +
                   "), should stand here.");
      body_.mode_names.push_back(line.value);
    }
    expect("end refmod");
  }

  void read_nodes() {
    expect("frame");
    std::vector<Vector3> positions;
    std::vector<MatrixX> phi, psi;
    std::set<int> ids;
    bool turned = false, rotations = false, stiffened = false, stressed = false;
    while (file_.next().key != "end frame") {
      if (file_.line().key != "new node") file_.fail("'new node' or 'end frame' should stand here.");
      const int id = file_.text().integer(file_.line().value, "node label");
      if (!ids.insert(id).second) file_.fail("node " + std::to_string(id) + " is given twice.");
      basis_->node_ids.push_back(id);
      if (file_.next().key != "rframe" || lower_case(file_.line().value) != "body ref")
        file_.fail("node " + std::to_string(id) + " is not given in the frame of the body (rframe = body ref).");

      file_.next();
      const SidTable origin = file_.table("origin", modes_, {{3, 1}});
      file_.next();
      const SidTable shape = file_.table("phi", modes_, {{3, modes_}});
      file_.next();
      const SidTable turn = file_.table("psi", modes_, {{3, modes_}});
      file_.next();
      const SidTable axes = file_.table("ap", modes_, {{3, 3}});
      if (file_.next().key == "sigma") {
        stressed = true;
        file_.table("sigma", modes_, {{6, 1}});
        file_.next();
      }
      if (file_.line().key != "end node") file_.fail("'end node' should stand here.");

      // What is said twice must agree: ∂origin/∂η = phi, ∂AP/∂η_k = psi_k~ AP.
      const std::string node = " of node " + std::to_string(id);
      for (int k = 0; k < modes_; ++k) {
        if (!origin.m1.empty())
          compare("origin" + node, origin.line, origin.first(k), "phi", shape.m0.col(k), shape.m0);
        if (!axes.m1.empty() && turn.structure != 0)
          compare("AP" + node, axes.line, axes.first(k), "psi", skew(turn.m0.col(k)) * axes.m0, turn.m0);
      }
      turned = turned || (axes.m0 - Matrix3::Identity()).cwiseAbs().maxCoeff() > 1e-9;
      for (const MatrixX& second : shape.m1) stiffened = stiffened || second.cwiseAbs().maxCoeff() > 0;
      rotations = rotations || (turn.m0.size() > 0 && turn.m0.cwiseAbs().maxCoeff() > 0);
      positions.emplace_back(origin.m0.col(0));
      phi.push_back(shape.m0), psi.push_back(turn.m0);
    }
    if (static_cast<int>(ids.size()) != nodes_)
      file_.fail(std::to_string(ids.size()) + " nodes, but the first line announces " + std::to_string(nodes_) + ".");

    const int n = nodes_;
    basis_->nodes.resize(3, n);
    basis_->modes.resize((rotations ? 6 : 3) * n, modes_);
    for (int i = 0; i < n; ++i) {
      basis_->nodes.col(i) = positions[static_cast<size_t>(i)];
      basis_->modes.middleRows(3 * i, 3) = phi[static_cast<size_t>(i)];
      if (!rotations) continue;
      basis_->modes.middleRows(3 * (n + i), 3) = psi[static_cast<size_t>(i)];
      for (int axis = 0; axis < 3; ++axis) basis_->rotations.push_back({i, axis});
    }
    basis_->nodal_mass.resize(n, n);
    note(std::to_string(n) + " nodes, " + (rotations ? "with" : "without") + " rotations (psi)");
    if (turned) note("axes of nodes (AP) that are not those of the body are left out; markers take the body's");
    if (stiffened) note("phi of order 1 (displacements of second order) is left out");
    if (stressed) note("stress modes (sigma) are left out");
  }

  void read_tables() {
    const int nm = modes_;
    struct Kind {
      const char* name;
      std::vector<SidShape> shapes;
      int highest_order;
    };
    const std::vector<Kind> kinds{{"mdCM", {{3, 1}}, 1},     {"J", {{3, 3}, {6, 1}}, 1}, {"Ct", {{nm, 3}}, 1},
                                  {"Cr", {{nm, 3}}, 1},      {"Me", {{nm, nm}}, 0},      {"Gr", {{3, 3 * nm}}, 0},
                                  {"Ge", {{nm, 3 * nm}}, 0}, {"Oe", {{nm, 6}}, 1},       {"ksigma", {{nm, 1}}, 0},
                                  {"Ke", {{nm, nm}}, 0},     {"De", {{nm, nm}}, 0}};
    while (file_.next().key != "end modal") {
      const auto kind = std::find_if(kinds.begin(), kinds.end(),
                                     [&](const Kind& k) { return lower_case(k.name) == file_.line().key; });
      if (kind == kinds.end()) file_.fail("no table is called '" + file_.line().key.substr(0, 40) + "'.");
      if (tables_.count(kind->name)) file_.fail("table " + std::string(kind->name) + " is given twice.");
      tables_[kind->name] = file_.table(kind->name, nm, kind->shapes, kind->highest_order);
    }
    for (const Kind& kind : kinds)
      if (!tables_.count(kind.name) && std::string(kind.name) != "ksigma" && std::string(kind.name) != "De")
        file_.fail("table " + std::string(kind.name) + " is missing.");
    expect("end part");
  }

  /// Tables that say the same thing: their largest difference, on the scale of `all`.
  void compare(const std::string& name, int line, const MatrixX& a, const std::string& other, const MatrixX& b,
               const MatrixX& all) {
    if (a.size() == 0) return;
    const double scale = std::max({a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff(), all.cwiseAbs().maxCoeff()});
    const double worst = scale > 0 ? (a - b).cwiseAbs().maxCoeff() / scale : 0;
    if (worst <= kDigits) return;
    const std::string text = name + " contradicts " + other + " by " + two_digits(worst) + " of the largest entry";
    if (!(worst <= kContradiction))
      refuse(text + ".", line, "write the file again with one program; lumped and consistent inertia differ by less.");
    if (!contradictions_.insert(name.substr(0, name.find(' ')) + other).second) return;  // once a kind
    note(text);
  }

  void settle_inertia() {
    const int nm = modes_;
    const SidTable &mdCM = tables_["mdCM"], &J = tables_["J"], &Ct = tables_["Ct"], &Cr = tables_["Cr"],
                   &Oe = tables_["Oe"];
    SidTable Gr = tables_["Gr"], Ge = tables_["Ge"];
    InertiaIntegrals& I = basis_->integrals;
    I.s0 = mdCM.m0.col(0);
    I.J0 = inertia_of(J.m0);
    I.Ct = Ct.m0.transpose();
    I.C0 = Cr.m0.transpose();
    I.Mff = tables_["Me"].m0;
    I.J1.resize(6, nm);
    for (int k = 0; k < nm; ++k) I.J1.col(k) = inertia_of(J.first(k));
    if (J.m1.empty() && nm > 0)
      for (int c = 0; c < 6; ++c) I.J1.row(c) = -Oe.m0.col(kOeColumn[c]).transpose() / kOeWeight[c];

    // By axes or by modes? Gr of the wrong order contradicts J and Cr.
    const MatrixX expected = gyroscopic_of_rotation(I);
    const bool axes = (by_modes(Gr.m0) - expected).norm() <= (Gr.m0 - expected).norm();
    if (axes) Gr.m0 = by_modes(Gr.m0), Ge.m0 = by_modes(Ge.m0);
    if (nm > 1) note(std::string("columns of Gr and Ge go by ") + (axes ? "axes" : "modes"));

    I.C1.resize(3 * nm, nm);
    I.J2.resize(6 * nm, nm);
    for (int k = 0; k < nm; ++k) {
      I.C1.middleRows<3>(3 * k) =
          Cr.m1.empty() ? MatrixX(0.5 * Ge.m0.middleCols<3>(3 * k).transpose()) : MatrixX(Cr.first(k).transpose());
      const MatrixX second = Oe.first(k);  // row l: -J2_lk, weighted
      for (int l = 0; l < nm; ++l)
        for (int c = 0; c < 6; ++c) I.J2(6 * k + c, l) = -second(l, kOeColumn[c]) / (2 * kOeWeight[c]);
    }
    if (Oe.m1.empty() && nm > 0) note("Oe of order 0: the inertia of second order in the deformation (J2) is left out");
    bool accelerated = false;
    for (const MatrixX& second : Ct.m1) accelerated = accelerated || second.cwiseAbs().maxCoeff() > 0;
    if (accelerated) note("Ct of order 1 (stiffening by acceleration) is left out");

    // J2 is symmetric in its modes; C1 is antisymmetric for displacements interpolated by scalars.
    MatrixX J2_transposed(6 * nm, nm), C1_transposed(3 * nm, nm);
    for (int k = 0; k < nm; ++k)
      for (int l = 0; l < nm; ++l) {
        J2_transposed.block<6, 1>(6 * l, k) = I.J2.block<6, 1>(6 * k, l);
        C1_transposed.block<3, 1>(3 * l, k) = I.C1.block<3, 1>(3 * k, l);
      }
    compare("Oe", Oe.line, I.J2, "its transpose in the modes (m1)", J2_transposed, I.J2);
    I.J2 = 0.5 * (I.J2 + J2_transposed).eval();
    const double coupling = nm > 0 ? I.C1.cwiseAbs().maxCoeff() : 0;
    I.antisymmetric = coupling == 0 || (I.C1 + C1_transposed).cwiseAbs().maxCoeff() <= kDigits * coupling;
    if (I.antisymmetric) I.C1 = 0.5 * (I.C1 - C1_transposed).eval();

    // What the tables say twice.
    MatrixX first(3, nm);
    for (int k = 0; k < nm; ++k) first.col(k) = mdCM.first(k).col(0);
    if (!mdCM.m1.empty()) compare("mdCM", mdCM.line, first, "Ct", I.Ct, I.Ct);
    compare("Oe", Oe.line, Oe.m0, "J (m1)", centrifugal(I), I.J1);
    compare("Gr", Gr.line, Gr.m0, "J (m1) and Cr", gyroscopic_of_rotation(I), I.J1);
    MatrixX gyroscopic = Ge.m0;  // antisymmetric in the modes: that part does the gyroscopic work
    for (int k = 0; k < nm; ++k)
      for (int l = 0; l < nm; ++l)
        gyroscopic.block<1, 3>(l, 3 * k) = 0.5 * (Ge.m0.block<1, 3>(l, 3 * k) - Ge.m0.block<1, 3>(k, 3 * l));
    compare("Ge", Ge.line, gyroscopic, "Cr (m1)", gyroscopic_of_modes(I), 2 * I.C1);
  }

  void settle_elasticity() {
    const SidTable &Me = tables_["Me"], &Ke = tables_["Ke"];
    if (tables_.count("ksigma") && modes_ > 0 && tables_["ksigma"].m0.cwiseAbs().maxCoeff() > 0)
      refuse("ksigma is not zero: the body is preloaded.", tables_["ksigma"].line, "export the unloaded body.");
    MatrixX K = 0.5 * (Ke.m0 + Ke.m0.transpose()), M = 0.5 * (Me.m0 + Me.m0.transpose());
    compare("Ke", Ke.line, Ke.m0, "its transpose", K, K);
    compare("Me", Me.line, Me.m0, "its transpose", M, M);
    const auto clean = [](MatrixX& a) {
      const VectorX root = a.diagonal().cwiseAbs().cwiseSqrt();
      bool diagonal = true;
      for (Eigen::Index j = 0; j < a.cols(); ++j)
        for (Eigen::Index i = 0; i < a.rows(); ++i)
          if (i != j) diagonal = diagonal && std::abs(a(i, j)) <= kOffDiagonal * root[i] * root[j];
      if (diagonal) a = MatrixX(a.diagonal().asDiagonal());
      return diagonal;
    };
    const bool diagonal = clean(K), uncoupled = clean(M);
    const bool unit = uncoupled && (modes_ == 0 || (M.diagonal().array() - 1).abs().maxCoeff() <= kOffDiagonal);
    basis_->diagonal = diagonal && unit;
    if (basis_->diagonal) M.setIdentity();
    basis_->integrals.Mff = M;
    basis_->stiffness = K.sparseView();
    basis_->modal_mass = M.sparseView();
    if (tables_.count("De") && modes_ > 0 && tables_["De"].m0.cwiseAbs().maxCoeff() > 0) {
      basis_->damping = tables_["De"].m0;
      note("a damping matrix (De) came with the body");
    }

    basis_->frequencies.resize(modes_);
    for (int k = 0; k < modes_; ++k) {
      const double hertz = std::sqrt(std::max(0.0, K(k, k) / M(k, k))) / (2 * std::numbers::pi);
      basis_->frequencies[k] = hertz;
      if (!basis_->diagonal) continue;
      // "Eigen Mode 7 : 51.626 Hz", printed to a thousandth.
      const std::string name = lower_case(body_.mode_names[static_cast<size_t>(k)]);
      const size_t colon = name.find(':'), unit_at = name.find("hz");
      if (name.rfind("eigen", 0) != 0 || colon == std::string::npos || unit_at == std::string::npos || unit_at < colon)
        continue;
      const double named = std::strtod(name.substr(colon + 1, unit_at - colon - 1).c_str(), nullptr);
      if (!(std::abs(named - hertz) <= 0.01 * hertz + 0.001))
        refuse("mode " + std::to_string(k + 1) + " is called '" + body_.mode_names[static_cast<size_t>(k)] +
                   "', but Ke and Me give " + two_digits(hertz) + " Hz.",
               Ke.line, "write the file again with one program.");
    }
  }

  /// The mass matrix at rest [m E, -s~, Ct; ., J, C0; ., ., Mff] is that of a body with independent modes.
  void require_positive() const {
    const InertiaIntegrals& I = basis_->integrals;
    const int nm = modes_;
    if (!(I.mass > 0)) refuse("the mass is " + two_digits(I.mass) + ".", 0, "a body has mass; write the file again.");
    const Vector3 center = I.s0 / I.mass;
    const Matrix3 c = skew(center), inertia = full_inertia(I.J0) + I.mass * c * c;
    const Vector3 principal = Eigen::SelfAdjointEigenSolver<Matrix3>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
    const double spread = principal.cwiseAbs().maxCoeff();
    if (!(principal[0] > -1e-9 * spread) || !(principal[0] + principal[1] - principal[2] > -1e-6 * spread))
      refuse("no body has the principal inertia " + two_digits(principal[0]) + " " + two_digits(principal[1]) + " " +
                 two_digits(principal[2]) + ".",
             tables_.at("J").line, "J is about the body frame, mdCM is mass times centre: both from one export.");
    MatrixX mass(6 + nm, 6 + nm);
    mass.setZero();
    mass.topLeftCorner<3, 3>() = I.mass * Matrix3::Identity();
    mass.block<3, 3>(0, 3) = -skew(I.s0);
    mass.block<3, 3>(3, 0) = skew(I.s0);
    mass.block<3, 3>(3, 3) = full_inertia(I.J0);
    mass.topRightCorner(3, nm) = I.Ct;
    mass.block(3, 6, 3, nm) = I.C0;
    mass.bottomLeftCorner(nm, 3) = I.Ct.transpose();
    mass.block(6, 3, nm, 3) = I.C0.transpose();
    mass.bottomRightCorner(nm, nm) = I.Mff;
    // On its own scale: a unit diagonal.
    if (!(mass.diagonal().minCoeff() > 0)) refuse_mass();
    const VectorX scale = mass.diagonal().cwiseSqrt().cwiseInverse();
    mass = scale.asDiagonal() * mass * scale.asDiagonal();
    if (Eigen::LLT<MatrixX>(mass).info() != Eigen::Success || !mass.allFinite()) refuse_mass();
    if (nm > 0) {
      const MatrixX K(basis_->stiffness);
      const VectorX values = Eigen::SelfAdjointEigenSolver<MatrixX>(K, Eigen::EigenvaluesOnly).eigenvalues();
      if (!(values[0] >= -1e-9 * std::max(values[nm - 1], 0.0)))
        refuse("Ke has a negative eigenvalue.", tables_.at("Ke").line, "export the unloaded, unbuckled body.");
    }
  }
  [[noreturn]] void refuse_mass() const {
    refuse("the mass matrix of m, mdCM, J, Ct, Cr and Me is not positive definite.", tables_.at("Me").line,
           "the modes are dependent or contain a rigid motion, or a table is spoilt; write the file again.");
  }

  std::string path_;
  SidFile file_;
  SidBody body_;
  std::shared_ptr<ModalBasis> basis_;
  std::map<std::string, SidTable> tables_;
  std::set<std::string> contradictions_;
  int nodes_ = 0, modes_ = 0;
};

}  // namespace

SidBody read_sid(const std::string& path) { return SidReader(path).read(); }

}  // namespace lithe
