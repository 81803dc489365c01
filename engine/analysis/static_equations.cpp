#include "engine/analysis/static_equations.h"

#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_sparse.h>

#include <Eigen/QR>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <limits>

#include "engine/base/error.h"
#include "engine/base/sundials_context_internal.h"

namespace lithe {
namespace {

constexpr double kRoundings = 4;  // of each term of a force, in units of its last bit
constexpr int kKrylov = 12;       // vectors of GMRES
constexpr double kKrylovTolerance = 0.02;
constexpr double kPenalties[] = {1e3, 1e6, 1e9};  // of a row, of the stiffness of what it holds

}  // namespace

/// KLU, as SUNDIALS wraps it.
class StaticEquations::Factor {
 public:
  explicit Factor(int size) {
    x_ = N_VNew_Serial(size, context_);
    b_ = N_VNew_Serial(size, context_);
    matrix_ = SUNSparseMatrix(size, size, 10 * size + 1, CSC_MAT, context_);
    if (x_ && matrix_) solver_ = SUNLinSol_KLU(x_, matrix_, context_);
    if (!b_ || !solver_)
      throw SimulationError("SUNDIALS cannot be set up", "find_equilibrium", "is the memory enough?");
    // No block triangular form: it begins with a matching, which costs the square of the number of rows, since they
    // have no diagonal; of a thousand hinges 0.3 s, ten times the factor.
    SUNLinSol_KLUGetCommon(solver_)->btf = 0;
  }
  Factor(const Factor&) = delete;
  ~Factor() {
    if (solver_) SUNLinSolFree(solver_);
    if (matrix_) SUNMatDestroy(matrix_);
    for (N_Vector x : {x_, b_})
      if (x) N_VDestroy(x);
    if (context_) SUNContext_Free(&context_);
  }

  bool factorize(const Eigen::SparseMatrix<double>& A) {
    const auto entries = A.nonZeros();
    if (SUNSparseMatrix_NNZ(matrix_) < entries) SUNSparseMatrix_Reallocate(matrix_, entries);
    std::copy_n(A.outerIndexPtr(), A.cols() + 1, SUNSparseMatrix_IndexPointers(matrix_));
    std::copy_n(A.innerIndexPtr(), entries, SUNSparseMatrix_IndexValues(matrix_));
    std::copy_n(A.valuePtr(), entries, SUNSparseMatrix_Data(matrix_));
    SUNLinSol_KLUReInit(solver_, matrix_, entries, SUNKLU_REINIT_PARTIAL);  // the pattern may have changed
    return SUNLinSolSetup(solver_, matrix_) == 0;
  }
  /// x <- A⁻¹ x.
  bool solve(VectorX& x) {
    map(b_) = x;
    if (SUNLinSolSolve(solver_, matrix_, x_, b_, 0) != 0 || !map(x_).allFinite()) return false;
    x = map(x_);
    return true;
  }

 private:
  static Eigen::Map<VectorX> map(N_Vector x) { return {N_VGetArrayPointer(x), N_VGetLength(x)}; }
  SUNContext context_ = make_sundials_context();
  N_Vector x_ = nullptr, b_ = nullptr;
  SUNMatrix matrix_ = nullptr;
  SUNLinearSolver solver_ = nullptr;
};

StaticEquations::StaticEquations(Evaluator& equations)
    : equations_(equations),
      velocities_(equations.layout().v_count()),
      rows_(equations.layout().row_count()),
      redundant_(rows_, 0),
      factor_(std::make_unique<Factor>(velocities_ + rows_)) {
  for (int row : equations.redundant_rows()) redundant_[row] = 1;
  for (VectorX* x : {&force, &still_, &round_off_, &magnitudes_}) x->setZero(velocities_);
  gap.setZero(rows_);
}
StaticEquations::~StaticEquations() = default;

void StaticEquations::leave_out_redundant(VectorX& x) const {
  for (int i = 0; i < rows_; ++i)
    if (redundant_[i]) x[i] = 0;
}

void StaticEquations::evaluate(double time, ConstVectorRef q, ConstVectorRef lambda) {
  time_ = time;
  q_ = q;
  equations_.evaluate(time, q, still_, Level::velocity);
  equations_.residual(still_, lambda, force);
  equations_.constraint(Level::position, gap);
  leave_out_redundant(gap);
}

VectorX StaticEquations::mass_times(ConstVectorRef d, ConstVectorRef lambda) const {
  VectorX product(velocities_);
  equations_.residual(d, lambda, product);
  return product - force;
}

bool StaticEquations::factorize(double shift, ConstVectorRef lambda) {
  shift_ = shift;
  // Blocks alone, which KLU factorises; those of contacts come with their factor.
  if (equations_.contacts())
    equations_.factorize({1, 0, shift}, still_, lambda, nullptr);
  else
    equations_.write_tangent({1, 0, shift}, still_, lambda, nullptr);
  collect();
  const int size = velocities_ + rows_;
  sparse_.resize(size, size);
  sparse_.setFromTriplets(entries_.begin(), entries_.end());
  sparse_.makeCompressed();
  if (!Eigen::Map<const VectorX>(sparse_.valuePtr(), sparse_.nonZeros()).allFinite()) return false;
  find_round_off(q_, lambda);
  return factor_->factorize(sparse_);
}

/// Refined once: forces and motions differ by ten orders, and one pass leaves round-off of the former in the latter.
bool StaticEquations::solve(VectorX& d, VectorX& l) const {
  VectorX b(velocities_ + rows_);
  b << d, l;
  VectorX x = b;
  if (!factor_->solve(x)) return false;
  VectorX left = b - sparse_ * x;
  if (!factor_->solve(left)) return false;
  x += left;
  d = x.head(velocities_);
  l = x.tail(rows_);
  return true;
}

/// out = [K + σM  Gᵀ; G  0] x by a central difference over `length`, in the norm of d. The pose evaluated last stays.
void StaticEquations::product(const VectorX& x, ConstVectorRef lambda, double length, VectorX& out) {
  const VectorX q = q_, here_force = force, here_gap = gap;
  const double size = x.head(velocities_).lpNorm<Eigen::Infinity>(), h = size > 0 ? length / size : 1;
  VectorX moved = q;
  const auto evaluate_at = [&](double step) {
    equations_.layout().retract(q, step * x.head(velocities_), moved);
    evaluate(time_, moved, lambda + step * x.tail(rows_));
    VectorX both(x.size());
    both << force, gap;
    return both;
  };
  out = evaluate_at(h);
  out = (out - evaluate_at(-h)) / (2 * h);
  evaluate(time_, q, lambda);
  out.head(velocities_) += shift_ * mass_times(x.head(velocities_), lambda);
  for (int i = 0; i < rows_; ++i)
    if (redundant_[i]) out[velocities_ + i] = x[velocities_ + i];
}

VectorX StaticEquations::stiffness_times(const VectorX& d, ConstVectorRef lambda, double length, double* coarse) {
  const VectorX q = q_;
  const double size = d.lpNorm<Eigen::Infinity>(), h = size > 0 ? length / size : 1;
  VectorX moved = q;
  const auto slope = [&](double step) {
    const auto force_at = [&](double t) -> VectorX {
      equations_.layout().retract(q, t * d, moved);
      evaluate(time_, moved, lambda);
      return force;
    };
    const VectorX ahead = force_at(step);
    return VectorX((ahead - force_at(-step)) / (2 * step));
  };
  const VectorX near = slope(h);
  VectorX product = (4 * near - slope(2 * h)) / 3;
  evaluate(time_, q, lambda);
  if (coarse) *coarse = d.dot(near);
  return product;
}

bool StaticEquations::surely_convex() const {
  const int size = velocities_;
  const VectorX diagonal = VectorX(sparse_.diagonal()).head(size).cwiseAbs();
  Eigen::SparseMatrix<double> S = sparse_.topLeftCorner(size, size), G = sparse_.bottomLeftCorner(rows_, size);
  S = Eigen::SparseMatrix<double>(0.5 * (S + Eigen::SparseMatrix<double>(S.transpose())));
  VectorX largest = VectorX::Zero(rows_), square = largest;  // of each row: stiffness of what it holds, |row|²
  for (int column = 0; column < size; ++column)
    for (Eigen::SparseMatrix<double>::InnerIterator entry(G, column); entry; ++entry) {
      if (entry.value() != 0) largest[entry.row()] = std::max(largest[entry.row()], diagonal[column]);
      square[entry.row()] += entry.value() * entry.value();
    }
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor;
  for (const double penalty : kPenalties) {
    const VectorX weights = (penalty * largest).cwiseQuotient(square.cwiseMax(std::numeric_limits<double>::min()));
    const Eigen::SparseMatrix<double> weighted = weights.asDiagonal() * G;
    factor.compute(S + Eigen::SparseMatrix<double>(G.transpose() * weighted));
    if (factor.info() == Eigen::Success) return true;
    if (rows_ == 0) break;
  }
  return false;
}

int StaticEquations::freedoms() const {
  return velocities_ - static_cast<int>(std::count(redundant_.begin(), redundant_.end(), 0));
}

bool StaticEquations::solve_exactly(VectorX& d, VectorX& l, ConstVectorRef lambda, double length) {
  if (!solve(d, l)) return false;
  // Unknowns of one size: motions by the largest, multipliers likewise.
  const int n = velocities_ + rows_;
  VectorX scale(n);
  const auto largest = [](const VectorX& x) {
    const double size = x.size() > 0 ? x.lpNorm<Eigen::Infinity>() : 0;
    return size > 0 ? size : 1;
  };
  scale << VectorX::Constant(velocities_, largest(d)), VectorX::Constant(rows_, largest(l));
  VectorX b(n), x(n), image(n);
  b << d, l;
  b.array() /= scale.array();
  const auto apply = [&](const VectorX& of, VectorX& out) {
    x = of.cwiseProduct(scale);
    product(x, lambda, length, image);
    VectorX top = image.head(velocities_), bottom = image.tail(rows_);
    if (!top.allFinite() || !solve(top, bottom)) return false;
    out.resize(n);
    out << top, bottom;
    out.array() /= scale.array();
    return true;
  };
  const double norm = b.norm();
  if (!(norm > 0)) return true;
  MatrixX V(n, kKrylov + 1), H = MatrixX::Zero(kKrylov + 1, kKrylov);
  V.col(0) = b / norm;
  VectorX w, y, right = VectorX::Zero(kKrylov + 1);
  right[0] = norm;
  for (int k = 0; k < kKrylov; ++k) {
    if (!apply(V.col(k), w)) return true;  // the factor's answer must do
    for (int i = 0; i <= k; ++i) {
      H(i, k) = V.col(i).dot(w);
      w -= H(i, k) * V.col(i);
    }
    H(k + 1, k) = w.norm();
    const MatrixX square = H.topLeftCorner(k + 2, k + 1);
    const VectorX wanted = right.head(k + 2);
    y = square.colPivHouseholderQr().solve(wanted);
    const double left = (square * y - wanted).norm();
    if (left <= kKrylovTolerance * norm || H(k + 1, k) <= 1e-12 * norm) break;
    V.col(k + 1) = w / H(k + 1, k);
  }
  x = (V.leftCols(y.size()) * y).cwiseProduct(scale);
  d = x.head(velocities_);
  l = x.tail(rows_);
  return x.allFinite();
}

/// |K| |q| + |Gᵀ| |λ| in units of the last bit: a stiff row is a small difference of large forces, and no search makes
/// it smaller than that.
void StaticEquations::find_round_off(ConstVectorRef q, ConstVectorRef lambda) {
  equations_.layout().magnitudes(q, magnitudes_);
  round_off_.setZero();
  for (int column = 0; column < sparse_.outerSize(); ++column) {
    const double size = column < velocities_ ? magnitudes_[column] : std::abs(lambda[column - velocities_]);
    for (Eigen::SparseMatrix<double>::InnerIterator entry(sparse_, column); entry; ++entry)
      if (entry.row() < velocities_) round_off_[entry.row()] += std::abs(entry.value()) * size;
  }
  round_off_ *= kRoundings * std::numeric_limits<double>::epsilon();
}

/// Compliant rows, which have no unknown here, are eliminated: Gᵀ κ G.
void StaticEquations::collect() {
  const int constraints_end = velocities_ + rows_;
  struct CompliantRow {
    double compliance = 0;
    std::vector<std::pair<int, double>> across, down;  // columns of G, rows of Gᵀ
  };
  std::vector<CompliantRow> compliant;
  entries_.clear();
  const auto is_left_out = [&](int i) { return i >= velocities_ && redundant_[i - velocities_]; };

  equations_.visit_blocks([&](int row, int column, ConstMatrixRef values) {
    for (int k = 0; k < values.cols(); ++k)
      for (int i = 0; i < values.rows(); ++i) {
        const int r = row + i, c = column + k;
        if (r >= constraints_end || c >= constraints_end) {
          const auto place = static_cast<std::size_t>(std::max(r, c) - constraints_end);
          if (place >= compliant.size()) compliant.resize(place + 1);
          if (r >= constraints_end && c >= constraints_end) {
            compliant[place].compliance = -values(i, k);
          } else if (values(i, k) != 0 && !is_left_out(std::min(r, c))) {
            (r >= constraints_end ? compliant[place].across : compliant[place].down)
                .emplace_back(std::min(r, c), values(i, k));
          }
        } else if (!is_left_out(r) && !is_left_out(c) && (values(i, k) != 0 || r == c)) {
          entries_.emplace_back(r, c, values(i, k));
        }
      }
  });
  for (const CompliantRow& row : compliant)
    for (const auto& [r, down] : row.down)
      for (const auto& [c, across] : row.across) entries_.emplace_back(r, c, down * across / row.compliance);
  for (int i = 0; i < rows_; ++i)
    if (redundant_[i]) entries_.emplace_back(velocities_ + i, velocities_ + i, 1.0);
}

}  // namespace lithe
