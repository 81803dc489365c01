#include "engine/assembly/tangent_factors.h"

#include <algorithm>

#include "engine/assembly/evaluator.h"
#include "engine/assembly/redundancy.h"
#include "engine/factor/block_products.h"

namespace lithe {
namespace {

constexpr int kMostContactRows = 1200;  // whose couplings are solved for exactly
constexpr double kDoubt = 1e-5;         // of a row's pivot beside its compliance: it may be round-off of long loops

}  // namespace

TangentFactors::TangentFactors(Evaluator& evaluator, Workspace& work, std::vector<int>& redundant_rows,
                               ContactForces* contacts)
    : evaluator_(evaluator),
      system_(evaluator.system()),
      blocks_(system_.blocks()),
      work_(work),
      redundant_rows_(redundant_rows),
      contacts_(contacts),
      factor_(blocks_, &evaluator.team()) {
  unknowns_.setZero(blocks_.velocity_count + work.residual.size() + work.tension.size());
  if (contacts_) contact_correction_ = std::make_unique<ContactCorrection<double>>();
}

TangentFactors::~TangentFactors() = default;

void TangentFactors::factorize(const TangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                               const VectorX* increment) {
  evaluator_.write_tangent(weights, v_dot, lambda, increment);
  if (contact_correction_) contact_correction_->clear();
  const bool stiff = contacts_ && (weights.position != 0 || weights.velocity != 0);
  if (stiff) contacts_->form(weights, increment);
  const bool many = stiff && contacts_->stiff_rows() > kMostContactRows;
  if (many) add_contact_diagonals(weights);
  factor_.factorize(work_.values);
  if (!factor_.weak_rows().empty()) exchange_weak_rows();
  if (!stiff || many) return;
  contact_correction_->form(*contacts_, weights.position, weights.velocity, unknown_count(),
                            [&](double* x) { factor_.solve(x); });
}

/// Of very many contacts, what they are to each body by itself: Newton converges more slowly, at linear cost.
void TangentFactors::add_contact_diagonals(const TangentWeights& weights) {
  const auto& frames = blocks_.frames;
  int at = 0;
  for (const ContactRows::Row& row : contacts_->rows().points()) {
    const int n = row.rows;
    const Eigen::Map<const MatrixX> by_x(contacts_->by_position().data() + at, n, n),
        by_u(contacts_->by_velocity().data() + at, n, n);
    at += n * n;
    for (const ContactRows::Side& side : row.sides) {
      if (side.frames == 0) continue;
      auto frame = std::lower_bound(frames.begin(), frames.end(), side.velocity,
                                    [](const auto& f, int velocity) { return f.v < velocity; });
      for (int k = 0; k < side.frames; ++k, ++frame) {
        const Eigen::Map<const MatrixX> H(contacts_->rows().values(side) + 6 * n * k, n, 6),
            H_right(contacts_->right().data() + side.H + 6 * n * k, n, 6);
        Eigen::Map<Matrix6>(work_.values.data() + frame->values).noalias() -=
            H.transpose() * (weights.position * by_x + weights.velocity * by_u) * H_right;
      }
    }
  }
}

/// A kept row e that comes to depend on the other kept ones must be left out instead of a row d that no longer depends
/// on them. The motion x with G x = 0 in all kept rows but e, where it is 1, tells: g_d = a g_e + (other kept rows)
/// with a = g_d x, so that the volume that the kept rows span grows by |a|, in rows of equal compliance.
void TangentFactors::exchange_weak_rows() {
  constexpr double kGain = 2;  // less is not worth a new factor, nor going back and forth
  const int velocities = blocks_.velocity_count, rows = static_cast<int>(work_.residual.size());
  for (int exchanges = 0; exchanges < static_cast<int>(redundant_rows_.size()); ++exchanges) {
    int weakest = -1, stronger = -1;
    double gain = kGain;
    for (int e : factor_.weak_rows()) {
      if (e >= rows) continue;  // compliant: of a force, whose stiffness is nearly none
      unknowns_.setZero();
      unknowns_[velocities + e] = 1;
      factor_.solve(unknowns_.data());
      weak_rates_.setZero(rows);
      add_rates(blocks_, work_.values, unknowns_.data(), weak_rates_);
      for (std::size_t k = 0; k < redundant_rows_.size(); ++k) {
        const int d = redundant_rows_[k];
        const double a = std::abs(weak_rates_[d] / weak_rates_[e]) * system_.row_scales()[e] / system_.row_scales()[d];
        if (a > gain) gain = a, weakest = e, stronger = static_cast<int>(k);
      }
    }
    if (weakest < 0) break;
    redundant_rows_[stronger] = weakest;
    std::sort(redundant_rows_.begin(), redundant_rows_.end());
    factor_.drop_rows(redundant_rows_);
    factor_.factorize(work_.values);
  }
}

void TangentFactors::solve(VectorRef rv, VectorRef rl) const {
  unknowns_.head(rv.size()) = rv;
  unknowns_.segment(rv.size(), rl.size()) = rl;
  unknowns_.tail(unknowns_.size() - rv.size() - rl.size()).setZero();
  factor_.solve(unknowns_.data());
  if (contact_correction_) contact_correction_->apply(unknowns_.data());
  rv = unknowns_.head(rv.size());
  rl = unknowns_.segment(rv.size(), rl.size());
}

/// S is linear in the weights: twice the real form gives its real and imaginary part. Compliant rows are not: -1/(k w).
void TangentFactors::form_complex(const ComplexTangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                                  const VectorX* increment) {
  if (!complex_) {
    complex_ = std::make_unique<ComplexPart>(blocks_, &evaluator_.team());
    complex_->unknowns.setZero(unknowns_.size());
    complex_->values.resize(work_.values.size());
  }
  auto& values = complex_->values;
  evaluator_.write_tangent({weights.position.imag(), weights.velocity.imag(), weights.acceleration.imag()}, v_dot,
                           lambda, increment);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = {0, work_.values[i]};
  evaluator_.write_tangent({weights.position.real(), weights.velocity.real(), weights.acceleration.real()}, v_dot,
                           lambda, increment);
  for (std::size_t i = 0; i < values.size(); ++i) values[i].real(work_.values[i]);
  // What no weight touches is real: G, and the share of a compliant row's tension in a joint's multipliers.
  const auto make_real = [&](int first, int count) {
    for (int i = first; i < first + count; ++i) values[i].imag(0);
  };
  for (const auto& G : blocks_.jacobians) {
    const int rows = blocks_.rows[G.rows].count;
    if (G.frame >= 0) make_real(G.values, 6 * rows);
    if (G.linear >= 0) make_real(G.linear_values, blocks_.linears[G.linear].size * rows);
  }
  const int rows = static_cast<int>(work_.residual.size());
  for (const auto& row : blocks_.rows) {
    if (row.compliant < 0) continue;
    for (int i = 0; i < row.count; ++i) {
      const int k = row.first - rows + i;
      const std::complex<double> stiffness =
          weights.position * work_.row_stiffness[k] + weights.velocity * work_.row_damping[k];
      values[row.compliant + i] = stiffness == 0.0 ? -1e30 : -1.0 / stiffness;
    }
  }
  for (const auto& c : blocks_.row_couplings) {
    const auto& row = blocks_.rows[c.rows];
    for (int i = 0; i < row.count * blocks_.rows[c.on].count; ++i) {
      const int k = row.compliant + i % row.count;
      // As write_tangent() left it, over the real compliance; now over the complex one.
      values[c.values + i] = work_.values[c.values + i] / work_.values[k] * values[k];
    }
  }
}

void TangentFactors::factorize_complex(const ComplexTangentWeights& weights, ConstVectorRef v_dot,
                                       ConstVectorRef lambda, const VectorX* increment) {
  form_complex(weights, v_dot, lambda, increment);
  complex_->factor.drop_rows(redundant_rows_);
  complex_->factor.factorize(complex_->values);
  complex_->contacts.clear();
  if (!contacts_) return;
  contacts_->form({1, 1, 1}, increment);
  complex_->contacts.form(*contacts_, weights.position, weights.velocity, unknown_count(),
                          [&](std::complex<double>* x) { complex_->factor.solve(x); });
}

void TangentFactors::solve_complex(ComplexVectorRef rv, ComplexVectorRef rl) const {
  ComplexVectorX& unknowns = complex_->unknowns;
  unknowns.head(rv.size()) = rv;
  unknowns.segment(rv.size(), rl.size()) = rl;
  unknowns.tail(unknowns.size() - rv.size() - rl.size()).setZero();
  complex_->factor.solve(unknowns.data());
  complex_->contacts.apply(unknowns.data());
  rv = unknowns.head(rv.size());
  rl = unknowns.segment(rv.size(), rl.size());
}

void TangentFactors::visit_blocks(const std::function<void(int, int, ConstMatrixRef)>& visit) const {
  lithe::visit_blocks(blocks_, work_.values, visit);
  if (contact_correction_ && contact_correction_->active())
    contact_correction_->visit([&](int row, int column, const MatrixX& block) { visit(row, column, block); });
}

std::vector<int> TangentFactors::find_dependent_rows(double tolerance) {
  const VectorX still = VectorX::Zero(blocks_.velocity_count), no_load = VectorX::Zero(work_.residual.size());
  evaluator_.write_tangent({0, 0, 1}, still, no_load, nullptr);
  VectorX reference = row_compliances(blocks_, work_.values);
  // Rows of forces give way, so that they depend on none: not even those that move no body as drawn.
  reference.tail(reference.size() - no_load.size()).setOnes();
  std::vector<int> doubtful;
  std::vector<int> dependent = factor_.factorize_revealing(work_.values, reference, tolerance, kDoubt, doubtful);
  std::erase_if(doubtful, [&](int row) { return row >= no_load.size(); });
  add_confirmed(doubtful, reference, tolerance, dependent);
  return dependent;
}

/// A pivot is the difference of large numbers: around a loop of a thousand hinges, 1e-8 is left where it should be
/// zero. The motion x that a row's impulse makes while the other rows hold, M x + Gᵀ z = g, G x = 0, gives the same
/// pivot as xᵀ M x, in which round-off counts squared.
void TangentFactors::add_confirmed(const std::vector<int>& doubtful, const VectorX& reference, double tolerance,
                                   std::vector<int>& dependent) {
  if (doubtful.empty()) return;
  std::vector<int> left_out = dependent;
  left_out.insert(left_out.end(), doubtful.begin(), doubtful.end());
  const VectorX no_load = VectorX::Zero(work_.residual.size());
  VectorX row = no_load, motion(blocks_.velocity_count), resting = motion, moving = motion;
  for (const int d : doubtful) {
    std::sort(left_out.begin(), left_out.end());
    factor_.drop_rows(left_out);
    factor_.factorize(work_.values);
    row.setZero(), motion.setZero();
    row[d] = 1;
    add_row_forces(blocks_, work_.values, static_cast<int>(row.size()), row.data(), nullptr, motion.data());
    row.setZero();
    solve(motion, row);
    evaluator_.residual(VectorX::Zero(motion.size()), no_load, resting);
    evaluator_.residual(motion, no_load, moving);
    if (motion.dot(moving - resting) > tolerance * reference[d])
      std::erase(left_out, d);
    else
      dependent.push_back(d);
  }
  std::sort(dependent.begin(), dependent.end());
  factor_.drop_rows(dependent);
  factor_.factorize(work_.values);
}

}  // namespace lithe
