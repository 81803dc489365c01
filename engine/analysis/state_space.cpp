#include "engine/analysis/state_space.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>

#include "engine/analysis/perturbation.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

/// How an input moves: by its value, its rate or its acceleration.
constexpr std::array<Motion, 3> kKinds = {Motion{1, 0, 0}, Motion{0, 1, 0}, Motion{0, 0, 1}};

void check(const System& system, const std::vector<const Input*>& inputs, const std::vector<Sensor>& outputs) {
  if (inputs.empty() || outputs.empty())
    throw SceneError(inputs.empty() ? "no input to linearize by" : "no output to linearize", "linearize",
                     inputs.empty() ? "give some of graph.add<Input>(...)" : "give sensors");
  const auto& known = system.graph().inputs();
  for (const Input* input : inputs)
    if (std::find(known.begin(), known.end(), input) == known.end())
      throw SceneError(input ? "input '" + input->name() + "' is of another graph" : "an input is null", "linearize",
                       "give inputs of the graph that the system is assembled of");
}

/// The finite eigenvalues of (A - s E) x = 0, at most `count`, by s = s₀ + 1/μ, (A - s₀ E)⁻¹ E x = μ x: infinite ones
/// have μ = 0, up to round-off, so the largest μ are taken.
std::vector<Complex> finite_eigenvalues(const MatrixX& A, const MatrixX& E, int count, double shift) {
  std::vector<Complex> all;
  if (count <= 0) return all;
  const MatrixX shifted = (A - shift * E).partialPivLu().solve(E);
  const Eigen::EigenSolver<MatrixX> solver(shifted, false);
  std::vector<Complex> mu(solver.eigenvalues().begin(), solver.eigenvalues().end());
  std::stable_sort(mu.begin(), mu.end(), [](Complex a, Complex b) { return std::abs(a) > std::abs(b); });
  for (int i = 0; i < std::min(count, static_cast<int>(mu.size())); ++i)
    if (std::abs(mu[static_cast<std::size_t>(i)]) > 0) all.push_back(shift + 1.0 / mu[static_cast<std::size_t>(i)]);
  return all;
}

void sort_by_size(std::vector<Complex>& values) {
  std::stable_sort(values.begin(), values.end(), [](Complex a, Complex b) {
    return std::abs(a) != std::abs(b) ? std::abs(a) < std::abs(b) : a.imag() < b.imag();
  });
}

/// One input and one output as ẋ = A x + b u, y = c x + d u; an input whose rates act is taken as the double integral
/// of another, u = v/s².
struct Single {
  MatrixX A, b, c;
  double d = 0;
  bool by_acceleration = false;  // b, d belong to ü; u and u̇ are the last two states
};

Single single(const StateSpace& s, int input, int output) {
  if (input < 0 || input >= static_cast<int>(s.inputs.size()) || output < 0 ||
      output >= static_cast<int>(s.outputs.size()))
    throw SceneError("there is no input " + std::to_string(input) + " with output " + std::to_string(output),
                     "StateSpace",
                     "it has " + std::to_string(s.inputs.size()) + " inputs and " + std::to_string(s.outputs.size()) +
                         " outputs, numbered from 0");
  Single one{s.A, s.B.col(input), s.C.row(output), s.D(output, input)};
  one.by_acceleration = !s.B_rate.col(input).isZero(0) || !s.B_acceleration.col(input).isZero(0) ||
                        s.D_rate(output, input) != 0 || s.D_acceleration(output, input) != 0;
  if (!one.by_acceleration) return one;
  const Eigen::Index n = s.A.rows();
  MatrixX A = MatrixX::Zero(n + 2, n + 2), b = MatrixX::Zero(n + 2, 1), c(1, n + 2);
  A.topLeftCorner(n, n) = s.A;
  A.col(n).head(n) = s.B.col(input), A.col(n + 1).head(n) = s.B_rate.col(input);
  A(n, n + 1) = 1;
  b.col(0).head(n) = s.B_acceleration.col(input);
  b(n + 1, 0) = 1;
  c << s.C.row(output), s.D(output, input), s.D_rate(output, input);
  return {A, b, c, s.D_acceleration(output, input), true};
}

/// Markov's parameters d, c b, c A b … tell by how much the degree of the denominator exceeds that of the numerator:
/// the first that is more than round-off.
int relative_degree(const Single& one) {
  constexpr double kZero = 1e-8;
  const Eigen::Index n = one.A.rows();
  // In time units in which A is of size 1, each beside what it could be.
  const double rate = std::max(one.A.norm(), 1e-300), c = one.c.norm(), b = one.b.norm();
  if (std::abs(one.d) > kZero * c * b / rate) return 0;
  VectorX x = one.b.col(0);
  for (int k = 1; k <= n; ++k) {
    const double moment = one.c.row(0).dot(x), possible = one.c.cwiseAbs().row(0).dot(x.cwiseAbs());
    if (std::abs(moment) > kZero * possible && possible > kZero * c * x.norm() * 1e-4) return k;
    x = one.A * x / rate;
  }
  return static_cast<int>(n) + 1;  // nothing arrives
}

std::vector<Complex> zeros_of(const Single& one) {
  const Eigen::Index n = one.A.rows();
  const int count = static_cast<int>(n) - relative_degree(one);
  if (count <= 0) return {};
  // Scaled, so that input and output are of the size of the states.
  const double b = std::max(one.b.norm(), 1e-300), c = std::max(one.c.norm(), 1e-300);
  MatrixX A = MatrixX::Zero(n + 1, n + 1), E = MatrixX::Zero(n + 1, n + 1);
  A.topLeftCorner(n, n) = one.A;
  A.topRightCorner(n, 1) = one.b / b;
  A.bottomLeftCorner(1, n) = one.c / c;
  A(n, n) = one.d / (b * c);
  E.topLeftCorner(n, n).setIdentity();
  // A shift to the right of what the eigenvalues of mechanisms are, of their size.
  const double size = one.A.eigenvalues().cwiseAbs().mean();
  std::vector<Complex> zeros = finite_eigenvalues(A, E, count, size > 0 ? 0.7548776662 * size : 1);
  sort_by_size(zeros);
  return zeros;
}

/// Directions and columns of one linearization.
class Columns {
 public:
  Columns(const System& system, const State& state, const std::vector<const Input*>& inputs,
          const std::vector<Sensor>& outputs, const LinearizeOptions& options, StateSpace& out)
      : near_(system, state, options.axes, options.step),
        inputs_(inputs),
        outputs_(outputs),
        out_(out),
        G_all_(near_.jacobian()),
        G_(G_all_(near_.rows(), Eigen::all)),
        rows_(G_),
        GT_(G_.rows() > 0 ? MatrixX(G_.transpose()) : MatrixX::Identity(1, 1)) {  // Eigen fails without columns
    const std::vector<int>& rolling = system.velocity_rows();
    for (std::size_t i = 0; i < near_.rows().size(); ++i)
      rolls_.push_back(std::binary_search(rolling.begin(), rolling.end(), near_.rows()[i]));
    M_.resize(near_.layout().v_count(), near_.layout().v_count());
    for (Eigen::Index j = 0; j < M_.cols(); ++j) M_.col(j) = near_.mass_times(VectorX::Unit(M_.rows(), j));
  }

  void minimal();
  void descriptor();

 private:
  using Direction = Perturbation::Direction;
  VectorX multipliers(const Direction& along) {
    if (G_.rows() == 0) return VectorX();
    return -GT_.solve(near_.residual(along));
  }
  VectorX position_rows(const Direction& along);

  Perturbation near_;
  const std::vector<const Input*>& inputs_;
  const std::vector<Sensor>& outputs_;
  StateSpace& out_;
  const MatrixX G_all_, G_;
  const RowSpace rows_;
  const Eigen::ColPivHouseholderQR<MatrixX> GT_;
  std::vector<bool> rolls_;  // of the independent rows: on velocities alone
  MatrixX M_;
};

/// ẋ = A x + …: each column's accelerations and multipliers are those of the equations.
void Columns::minimal() {
  const Linearization& l = out_.about;
  const MatrixX &Zp = l.position_basis, &Zv = l.velocity_basis;
  const Eigen::Index np = Zp.cols(), nw = Zv.cols(), ny = static_cast<Eigen::Index>(out_.outputs.size()),
                     nu = static_cast<Eigen::Index>(inputs_.size());
  const Eigen::PartialPivLU<MatrixX> mass(l.E.bottomRightCorner(nw, nw));
  out_.A = l.A;
  if (nw > 0) out_.A.bottomRows(nw) = mass.solve(l.A.bottomRows(nw));
  out_.C.resize(ny, np + nw);

  // 1. Along the states.
  for (Eigen::Index j = 0; j < np + nw; ++j) {
    Direction along;
    if (j < np) {
      along.position = Zp.col(j);
      along.velocity = -rows_.shortest(near_.velocity_rows(along));
    } else {
      along.velocity = Zv.col(j - np);
    }
    along.acceleration = -rows_.shortest(near_.acceleration_rows(along));
    if (nw > 0) along.acceleration += Zv * out_.A.col(j).tail(nw);
    along.multipliers = multipliers(along);
    out_.C.col(j) = near_.sensors(along, outputs_);
  }

  // 2. Along value, rate and acceleration of each input.
  const std::array<std::pair<MatrixX*, MatrixX*>, 3> columns = {
      std::pair(&out_.B, &out_.D), {&out_.B_rate, &out_.D_rate}, {&out_.B_acceleration, &out_.D_acceleration}};
  for (std::size_t k = 0; k < kKinds.size(); ++k) {
    auto [B, D] = columns[k];
    B->setZero(np + nw, nu), D->setZero(ny, nu);
    for (Eigen::Index i = 0; i < nu; ++i) {
      Direction along;
      along.input = inputs_[static_cast<std::size_t>(i)];
      along.motion = kKinds[k];
      if (k == 0) along.position = -rows_.shortest(position_rows(along));
      along.velocity = -rows_.shortest(near_.velocity_rows(along));
      along.acceleration = -rows_.shortest(near_.acceleration_rows(along));
      VectorX speed = along.velocity;
      if (k == 0) speed -= near_.transport(along.position);
      B->col(i).head(np) = Zp.transpose() * speed;
      if (nw > 0) {
        B->col(i).tail(nw) = -mass.solve(Zv.transpose() * near_.residual(along));
        along.acceleration += Zv * B->col(i).tail(nw);
      }
      along.multipliers = multipliers(along);
      D->col(i) = near_.sensors(along, outputs_);
    }
  }
}

/// Those that are on velocities alone have none.
VectorX Columns::position_rows(const Direction& along) {
  VectorX g = near_.position_rows(along);
  for (Eigen::Index i = 0; i < g.size(); ++i)
    if (rolls_[static_cast<std::size_t>(i)]) g[i] = 0;
  return g;
}

/// E ẋ = A x + B u, x = (ζ, ξ, λ, u*).
void Columns::descriptor() {
  const Eigen::Index nv = M_.rows(), nr = G_.rows(), nu = static_cast<Eigen::Index>(inputs_.size()),
                     ny = static_cast<Eigen::Index>(out_.outputs.size());
  // 1. Which inputs act by their rates, apart from what the rows' own derivatives tell.
  std::vector<std::array<VectorX, 3>> force(inputs_.size()), seen(inputs_.size());  // exactly zero where nothing acts
  std::vector<VectorX> rows(inputs_.size()), rolling(inputs_.size());
  std::vector<Eigen::Index> first(inputs_.size(), -1);  // of u*
  Eigen::Index n = 2 * nv + nr;
  const auto unit = [&](Eigen::Index j) { return VectorX(VectorX::Unit(nv, j)); };
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    bool by_rate = false;
    for (std::size_t k = 0; k < 3; ++k) {
      Direction along;
      along.input = inputs_[i];
      along.motion = kKinds[k];
      force[i][k] = near_.residual(along);
      seen[i][k] = near_.sensors(along, outputs_);
      if (k == 0) rows[i] = position_rows(along), rolling[i] = near_.velocity_rows(along);
      by_rate |= k > 0 && (!force[i][k].isZero(0) || !seen[i][k].isZero(0));
    }
    if (by_rate) first[i] = n, n += 3;
  }
  auto& d = out_.descriptor;
  d.E.setZero(n, n), d.A.setZero(n, n), d.B.setZero(n, nu), d.C.setZero(ny, n), d.D.setZero(ny, nu);

  // 2. ζ̇ = ξ - T ζ,  M ξ̇ = -K ζ - C ξ - Gᵀ λ - F u,  0 = G ζ + g_u u.
  MatrixX by_acceleration(ny, nv);
  d.E.topLeftCorner(nv, nv).setIdentity();
  d.E.block(nv, nv, nv, nv) = M_;
  d.A.block(0, nv, nv, nv).setIdentity();
  for (Eigen::Index j = 0; j < nv; ++j) {
    const Direction position{unit(j), {}, {}}, velocity{{}, unit(j), {}}, acceleration{{}, {}, unit(j)};
    d.A.col(j).head(nv) = -near_.transport(unit(j));
    d.A.col(j).segment(nv, nv) = -near_.residual(position);
    d.A.col(nv + j).segment(nv, nv) = -near_.residual(velocity);
    const VectorX turned = near_.velocity_rows(position);
    for (Eigen::Index r = 0; r < nr; ++r) {
      if (rolls_[static_cast<std::size_t>(r)])
        d.A(2 * nv + r, j) = turned[r], d.A(2 * nv + r, nv + j) = G_(r, j);
      else
        d.A(2 * nv + r, j) = G_(r, j);
    }
    d.C.col(j) = near_.sensors(position, outputs_);
    d.C.col(nv + j) = near_.sensors(velocity, outputs_);
    by_acceleration.col(j) = near_.sensors(acceleration, outputs_);
  }
  d.A.block(nv, 2 * nv, nv, nr) = -G_.transpose();
  for (Eigen::Index r = 0; r < nr; ++r) {
    Direction along;
    along.multipliers = VectorX::Unit(nr, r);
    d.C.col(2 * nv + r) = near_.sensors(along, outputs_);
  }
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    for (Eigen::Index r = 0; r < nr; ++r)
      d.B(2 * nv + r, column) = rolls_[static_cast<std::size_t>(r)] ? rolling[i][r] : rows[i][r];
    if (first[i] < 0) {
      d.B.col(column).segment(nv, nv) = -force[i][0];
      d.D.col(column) = seen[i][0];
      continue;
    }
    // u* = (u, u̇, ü) as states: 0 = u - u*₀, u̇*₀ = u*₁, u̇*₁ = u*₂.
    const Eigen::Index at = first[i];
    for (Eigen::Index k = 0; k < 3; ++k) {
      d.A.col(at + k).segment(nv, nv) = -force[i][static_cast<std::size_t>(k)];
      d.C.col(at + k) = seen[i][static_cast<std::size_t>(k)];
    }
    d.A(at, at) = -1, d.B(at, column) = 1;
    d.E(at + 1, at) = d.E(at + 2, at + 1) = 1;
    d.A(at + 1, at + 1) = d.A(at + 2, at + 2) = 1;
  }
  // 3. What sensors see of accelerations is seen of what causes them.
  if (nv > 0 && ny > 0) {
    const Eigen::PartialPivLU<MatrixX> mass(MatrixX(M_.transpose()));
    const MatrixX seen_of_force = mass.solve(MatrixX(by_acceleration.transpose())).transpose();
    d.C += seen_of_force * d.A.middleRows(nv, nv);
    d.D += seen_of_force * d.B.middleRows(nv, nv);
  }
  // 4. Names.
  const Layout& layout = near_.layout();
  for (const char* what : {"", "rate of "})
    for (Eigen::Index j = 0; j < nv; ++j)
      d.states.push_back((*what ? "" : "small ") + std::string(what) + layout.velocity_name(static_cast<int>(j)));
  for (const int row : near_.rows()) d.states.push_back("lambda of " + layout.row_name(row));
  for (std::size_t i = 0; i < inputs_.size(); ++i)
    if (first[i] >= 0)
      for (const char* what : {"", "rate of ", "acceleration of "}) d.states.push_back(what + inputs_[i]->name());
}

}  // namespace

StateSpace linearize(const System& system, const State& state, const std::vector<const Input*>& inputs,
                     const std::vector<Sensor>& outputs, const LinearizeOptions& options) {
  check(system, inputs, outputs);
  StateSpace out;
  out.about = linearize(system, state, options);
  for (const Input* input : inputs) out.inputs.push_back(input->name()), out.input_units.push_back(input->unit());
  for (const Sensor& sensor : outputs)
    for (std::size_t c = 0; c < sensor.columns().size(); ++c)
      out.outputs.push_back(sensor.columns()[c]), out.output_units.push_back(sensor.unit(c));
  Columns columns(system, state, inputs, outputs, options, out);
  columns.minimal();
  columns.descriptor();
  return out;
}

Eigen::MatrixXcd StateSpace::response(Complex s) const {
  const Eigen::MatrixXcd input = B + s * B_rate + s * s * B_acceleration;
  Eigen::MatrixXcd H = D + s * D_rate + s * s * D_acceleration;
  if (A.rows() == 0) return H;
  const Eigen::MatrixXcd pencil = s * MatrixX::Identity(A.rows(), A.cols()) - A.cast<Complex>();
  return H + C * pencil.partialPivLu().solve(input);
}

Eigen::MatrixXcd StateSpace::descriptor_response(Complex s) const {
  const auto& d = descriptor;
  const Eigen::MatrixXcd pencil = s * d.E - d.A.cast<Complex>();
  return d.C * pencil.partialPivLu().solve(d.B.cast<Complex>()) + d.D.cast<Complex>();
}

std::vector<Complex> StateSpace::poles() const {
  std::vector<Complex> all;
  for (const Mode& mode : about.modes) {
    all.push_back(mode.eigenvalue);
    if (mode.eigenvalue.imag() > 0) all.push_back(std::conj(mode.eigenvalue));
  }
  if (static_cast<Eigen::Index>(all.size()) != A.rows()) {  // a part of the modes was asked for
    const Eigen::VectorXcd own = A.eigenvalues();
    all.assign(own.begin(), own.end());
  }
  sort_by_size(all);
  return all;
}

std::vector<Complex> StateSpace::zeros(int input, int output) const { return zeros_of(single(*this, input, output)); }

TransferFunction StateSpace::transfer_function(int input, int output) const {
  TransferFunction h{inputs.at(static_cast<std::size_t>(input)), outputs.at(static_cast<std::size_t>(output)), poles(),
                     zeros(input, output), 1};
  // The gain by one value away from all of them.
  double size = 1;
  for (const Complex p : h.poles) size = std::max(size, std::abs(p));
  for (const Complex z : h.zeros) size = std::max(size, std::abs(z));
  const Complex s = 1.7 * size;
  const Complex shape = h(s);
  h.gain = (response(s)(output, input) / shape).real();
  return h;
}

Complex TransferFunction::operator()(Complex s) const {
  // Factors in pairs, so that high degrees do not overflow.
  Complex product = gain;
  for (std::size_t i = 0; i < std::max(poles.size(), zeros.size()); ++i) {
    if (i < zeros.size()) product *= s - zeros[i];
    if (i < poles.size()) product /= s - poles[i];
  }
  return product;
}

}  // namespace lithe
