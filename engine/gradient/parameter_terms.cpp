#include "engine/gradient/parameter_terms.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "engine/assembly/body_check.h"
#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/factor/block_products.h"
#include "engine/gradient/differences.h"
#include "engine/gradient/row_rates.h"

namespace lithe {

namespace {

constexpr double kDrawnNoise = 1e-12;  // of a term's parts: what drawing elsewhere leaves where nothing acts
constexpr double kFarAway = 1e-2;      // of the largest coordinate: gaps are differences of such
constexpr double kShaped = 1e-11;      // of a change, by its curvature: it is straight
constexpr double kSamePlace = 1e-9;    // m, rad: the drawing stands on its joints

VectorX random_entries(std::mt19937& random, Eigen::Index size) {
  VectorX x(size);
  for (double& value : x) value = static_cast<double>(random()) / 2147483648.0 - 1;
  return x;
}

/// Drawn q and v of all bodies of a graph.
void read_drawn(const SystemGraph& graph, const Layout& layout, VectorX& q, VectorX& v) {
  q.setZero(layout.q_count());
  v.setZero(layout.v_count());
  int at_q = 0, at_v = 0;
  const auto& bodies = graph.bodies();
  for (std::size_t i = 1; i < bodies.size(); ++i) {  // behind the ground
    const Coordinates c = bodies[i].body->coordinates();
    read_initial_state(*bodies[i].body, q.segment(at_q, c.q_count()), v.segment(at_v, c.v_count()));
    at_q += c.q_count(), at_v += c.v_count();
  }
}

/// Moved drawings are evaluated, and never run: forward dynamics need not be planned.
ParametricScene by_constraints(ParametricScene scene) {
  scene.forward_dynamics = false;
  return scene;
}

/// The name without its digits: parameters of one kind.
std::string kind_of(const std::string& name) {
  std::string kind;
  for (char c : name)
    if (c < '0' || c > '9') kind += c;
  return kind;
}

}  // namespace

/// Where drawings of a group lie, in steps, with the weights of f' in their differences from the nominal one: exact for
/// what is linear, for quadratics, and for cubics; of others the error is (h/4)³ f⁗/12.
std::span<const Offset> ParameterTerms::offsets(Shape shape) {
  static constexpr Offset kForLinear[] = {{1, 1}}, kForQuadratic[] = {{1, 0.5}, {-1, -0.5}},
                          kForOthers[] = {{0.25, 4}, {-0.25, -4.0 / 3}, {0.5, -4.0 / 6}};
  switch (shape) {
    case Shape::linear:
      return kForLinear;
    case Shape::quadratic:
      return kForQuadratic;
    default:
      return kForOthers;
  }
}

struct ParameterTerms::Group {
  Shape shape;
  std::vector<int> members;
  std::vector<char> taken;                              // terms
  std::vector<std::unique_ptr<MovedDrawing>> drawings;  // at offsets()
};

/// How the nominal drawing looks at the probes, with random weights.
struct ParameterTerms::Search {
  struct Look {
    std::size_t probe;
    WeightedSum sum;
    MatrixX mu, nu;
  };
  std::vector<Look> looks;
  MatrixX nominal, sizes;         // terms x looks
  VectorX columns;                // columns x probes, flat
  VectorX drawn_q, drawn_v;       // of the nominal drawing
  std::vector<char> start_apart;  // of each parameter: its start is told by drawings of its own
};

std::unique_ptr<MovedDrawing> ParameterTerms::draw(const std::vector<int>& members,
                                                   const std::vector<double>& steps) const {
  const log::Quiet quiet;
  std::vector<DesignParameter> values = parameters_;
  for (std::size_t i = 0; i < members.size(); ++i) {
    DesignParameter& p = values[static_cast<std::size_t>(members[i])];
    p.value += steps[i] * p.step;
  }
  auto drawn = std::make_unique<MovedDrawing>(scene_, values);
  const Layout &layout = drawn->equations.layout(), &as_drawn = nominal_.system().layout();
  if (layout.q_count() != as_drawn.q_count() || layout.v_count() != as_drawn.v_count() ||
      layout.row_count() != as_drawn.row_count())
    throw SceneError("the parameter '" + parameters_[static_cast<std::size_t>(members.front())].name +
                         "', or one like it, changes which coordinates or rows there are",
                     "scene '" + scene_.name + "'", "keep the elements the same for all values of a parameter");
  return drawn;
}

ParameterTerms::ParameterTerms(const ParametricScene& scene, const std::vector<DesignParameter>& parameters,
                               const Drawing& nominal, const std::vector<State>& probes,
                               const std::vector<Drawing::Place>& columns)
    : scene_(by_constraints(scene)),
      parameters_(parameters),
      nominal_(nominal),
      probes_(probes),
      columns_(columns),
      slices_(static_cast<int>(nominal.system().layout().bodies().size())),
      constraints_(static_cast<int>(nominal.system().layout().rows().size())),
      equations_(nominal.system()) {
  for (const auto& row : nominal.system().blocks().rows) forces_ += row.compliant >= 0;
  touched_.resize(parameters_.size());
  shapes_.assign(parameters_.size(), Shape::linear);
  starts_.resize(parameters_.size());
}

ParameterTerms::~ParameterTerms() = default;

int ParameterTerms::group_count() const {
  std::size_t count = 0;
  for (const auto& group : groups_) count += group->drawings.size();
  return static_cast<int>(count);
}

/// One number a term and a want.
void ParameterTerms::terms(Evaluator& equations, const State& state, const WeightedSum& sum, const MatrixX& mu,
                           const MatrixX& nu, MatrixX& values, MatrixX* sizes) const {
  const Layout& layout = equations.layout();
  const BlockStructure& blocks = equations.system().blocks();
  const Workspace& work = equations.workspace();
  const int rows = layout.row_count();
  using Rows = WeightedSum::Rows;
  equations.recall(state.quarter_turns);
  equations.evaluate(state.time, state.q, state.v,
                     sum.rows == Rows::acceleration ? Level::acceleration : Level::velocity);
  // Bodies with loads, without what rows do.
  const bool moves = mu.cols() > 0;
  VectorX tension = -work.tension;
  if (moves) {
    r_.resize(layout.v_count());
    equations.residual(sum.a, VectorX::Zero(rows), r_);
    if (sum.forces) {
      if (tension.size() > 0) add_row_forces(blocks, work.values, rows, nullptr, tension.data(), r_.data());
    } else {
      force_.resize(r_.size());
      equations.residual(VectorX::Zero(r_.size()), VectorX::Zero(rows), force_);
      r_ -= force_;
    }
  }
  VectorX row(rows);
  switch (sum.rows) {
    case Rows::position:
      row = work.residual;
      break;
    case Rows::velocity:
      equations.constraint(Level::velocity, row);
      break;
    case Rows::acceleration:
      equations.constraint(Level::acceleration, row);
      row = -row;
      add_rates(blocks, work.values, sum.a.data(), row);
      break;
    case Rows::product:
      row.setZero();
      add_rates(blocks, work.values, sum.u.data(), row);
      break;
  }
  values.setZero(term_count(), nu.cols());
  if (sizes) sizes->setZero(term_count(), nu.cols());
  const double far = sizes ? largest_entry(state.q) : 0;
  for (Eigen::Index k = 0; k < nu.cols(); ++k) {
    const VectorX rates = moves ? rates_of_all_rows(blocks, work.values, mu.col(k)) : VectorX::Zero(rows);
    int term = 0;
    for (const auto& b : layout.bodies()) {
      const int size = (b.frame ? 6 : 0) + b.linear;
      if (moves) {
        values(term, k) = mu.col(k).segment(b.v, size).dot(r_.segment(b.v, size));
        if (sizes) (*sizes)(term, k) = mu.col(k).segment(b.v, size).cwiseAbs().dot(r_.segment(b.v, size).cwiseAbs());
      }
      ++term;
    }
    for (const auto& c : layout.rows()) {
      double value = 0, size = 0;
      for (int i = c.first; i < c.first + c.count; ++i) {
        const double loaded = moves && sum.l.size() > 0 ? sum.l[i] * rates[i] : 0, held = nu(i, k) * row[i];
        value += loaded + held;
        size += std::abs(loaded) + std::abs(held) + kFarAway * far * std::abs(nu(i, k));
      }
      values(term, k) = value;
      if (sizes) (*sizes)(term, k) = size;
      ++term;
    }
    for (const auto& c : blocks.rows) {
      if (c.compliant < 0) continue;
      for (int i = c.first; moves && sum.forces && i < c.first + c.count; ++i) {
        values(term, k) += work.tension[i - rows] * rates[i];
        if (sizes) (*sizes)(term, k) += std::abs(work.tension[i - rows] * rates[i]);
      }
      ++term;
    }
  }
}

/// Draws the group at + and - a step, and by steps of lengths of their own: what a term makes of these tells which
/// parameter moves it. False: more than one does somewhere.
bool ParameterTerms::decode(std::vector<int> members, Search& search) {
  const std::size_t n = members.size();
  std::vector<double> lengths(n);
  for (std::size_t i = 0; i < n; ++i) lengths[i] = 1.1 + 0.8 * (static_cast<double>(i) + 0.5) / static_cast<double>(n);
  const std::unique_ptr<MovedDrawing> drawings[] = {
      draw(members, std::vector<double>(n, 1.0)), draw(members, std::vector<double>(n, -1.0)), draw(members, lengths)};

  /// Whose length explains the values at + (0), - (1) and that length (2), of several numbers; -1: nobody moves them,
  /// -2: more than one. Tells the shape.
  const auto owner = [&](const VectorX& at_zero, const VectorX(&at)[3], double noise, Shape& shape) {
    const VectorX slope = (at[0] - at[1]) / 2, curve = (at[0] + at[1]) / 2 - at_zero, far = at[2] - at_zero;
    const double size = std::max({largest_entry(slope), largest_entry(curve), largest_entry(far)});
    shape = Shape::linear;
    if (size <= noise) return -1;
    int best = 0;
    double off = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < n; ++i) {
      const double error = largest_entry(far - lengths[i] * slope - lengths[i] * lengths[i] * curve);
      if (error < off) off = error, best = static_cast<int>(i);
    }
    if (off > 1e-4 * size + 4 * noise) return -2;
    if (largest_entry(curve) > kShaped * size + noise) shape = Shape::quadratic;
    if (off > kShaped * size + 4 * noise) shape = Shape::general;
    return best;
  };

  std::vector<std::vector<int>> touched(n);
  std::vector<Shape> shapes(n, Shape::linear);
  const auto take = [&](int term, int who, Shape shape) {
    touched[static_cast<std::size_t>(who)].push_back(term);
    shapes[static_cast<std::size_t>(who)] = std::max(shapes[static_cast<std::size_t>(who)], shape);
  };
  const auto count = static_cast<Eigen::Index>(probes_.size());
  std::array<MatrixX, 3> values;
  std::array<VectorX, 3> seen;
  MatrixX column;
  for (std::size_t d = 0; d < 3; ++d) {
    values[d].resize(term_count(), static_cast<Eigen::Index>(search.looks.size()));
    for (std::size_t i = 0; i < search.looks.size(); ++i) {
      const Search::Look& look = search.looks[i];
      terms(drawings[d]->equations, probes_[look.probe], look.sum, look.mu, look.nu, column);
      values[d].col(static_cast<Eigen::Index>(i)) = column;
    }
    seen[d].resize(static_cast<Eigen::Index>(columns_.size()) * count);
    for (Eigen::Index i = 0; i < count; ++i)
      for (std::size_t c = 0; c < columns_.size(); ++c)
        seen[d][static_cast<Eigen::Index>(c) * count + i] =
            drawings[d]->value(columns_[c], probes_[static_cast<std::size_t>(i)]);
  }
  Shape shape;
  for (int t = 0; t < term_count(); ++t) {
    const VectorX at[3] = {values[0].row(t).transpose(), values[1].row(t).transpose(), values[2].row(t).transpose()};
    const int who = owner(search.nominal.row(t).transpose(), at,
                          kDrawnNoise * search.sizes.row(t).lpNorm<Eigen::Infinity>(), shape);
    if (who == -2) return false;
    if (who >= 0) take(t, who, shape);
  }
  for (int c = 0; c < static_cast<int>(columns_.size()); ++c) {
    const auto of = [&](const VectorX& x) -> VectorX { return x.segment(c * count, count); };
    const VectorX at[3] = {of(seen[0]), of(seen[1]), of(seen[2])};
    const int who = owner(of(search.columns), at, kDrawnNoise * largest_entry(of(search.columns)), shape);
    if (who == -2) return false;
    if (who >= 0) take(term_count() + c, who, shape);
  }

  // The drawn start, body by body.
  std::array<VectorX, 3> turns, speeds;
  const Layout& layout = nominal_.system().layout();
  VectorX q;
  for (std::size_t d = 0; d < 3; ++d) {
    read_drawn(drawings[d]->drawing.system().graph(), layout, q, speeds[d]);
    turns[d].resize(layout.v_count());
    layout.difference(search.drawn_q, q, turns[d]);
    speeds[d] -= search.drawn_v;
  }
  std::vector<std::vector<Start>> starts(n);
  bool apart = false;
  for (const auto& b : layout.bodies()) {
    const int size = (b.frame ? 6 : 0) + b.linear;
    VectorX at[3];
    for (std::size_t d = 0; d < 3; ++d) {
      at[d].resize(2 * size);
      at[d] << turns[d].segment(b.v, size), speeds[d].segment(b.v, size);
    }
    const double noise = kDrawnNoise * (1 + largest_entry(search.drawn_q) + largest_entry(search.drawn_v));
    const int who = owner(VectorX::Zero(2 * size), at, noise, shape);
    apart = apart || who == -2 || (who >= 0 && shape == Shape::general);
    if (who < 0) continue;
    const VectorX slope = (at[0] - at[1]) / (2 * parameters_[static_cast<std::size_t>(members[who])].step);
    starts[static_cast<std::size_t>(who)].push_back({b.v, slope.head(size), slope.tail(size)});
  }
  for (std::size_t i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(members[i]);
    touched_[k] = std::move(touched[i]);
    shapes_[k] = shapes[i];
    starts_[k] = std::move(starts[i]);
    search.start_apart[k] = apart;
  }
  return true;
}

/// The drawn start by one parameter, drawn alone and not assembled.
void ParameterTerms::difference_start(int k) {
  const log::Quiet quiet;
  const Layout& layout = nominal_.system().layout();
  const double h = parameters_[static_cast<std::size_t>(k)].step;
  VectorX q, v, q0, v0, d(layout.v_count()), turn = VectorX::Zero(layout.v_count()), velocity = turn;
  read_drawn(nominal_.system().graph(), layout, q0, v0);
  const auto look = [&](double steps) {
    const std::vector<DesignParameter> values = moved_parameter(parameters_, k, steps);
    draw_only(scene_, values, [&](const SystemGraph& graph) { read_drawn(graph, layout, q, v); });
    layout.difference(q0, q, d);
    v -= v0;
  };
  // Straight: two drawings tell.
  look(2);
  const VectorX far = d, far_speed = v;
  look(1);
  const double size = std::max(largest_entry(d), largest_entry(v));
  if (largest_entry(far - 2 * d) <= kShaped * size + kDrawnNoise * (1 + largest_entry(q0)) &&
      largest_entry(far_speed - 2 * v) <= kShaped * size + kDrawnNoise * (1 + largest_entry(v0))) {
    starts_[static_cast<std::size_t>(k)] = {{0, far / (2 * h), far_speed / (2 * h)}};
    return;
  }
  for (const Offset& offset : kOffsets) {
    look(offset.steps);
    turn += offset.weight / h * d;
    velocity += offset.weight / h * v;
  }
  starts_[static_cast<std::size_t>(k)] = {{0, turn, velocity}};
}

/// Parameters with different terms share drawings: those that need many first, the others beside them.
void ParameterTerms::gather() {
  for (const Shape shape : {Shape::general, Shape::quadratic, Shape::linear})
    for (int k = 0; k < count(); ++k) {
      const auto& terms = touched_[static_cast<std::size_t>(k)];
      if (terms.empty() || shapes_[static_cast<std::size_t>(k)] != shape) continue;
      const auto free = std::find_if(groups_.begin(), groups_.end(), [&](const auto& group) {
        return std::none_of(terms.begin(), terms.end(),
                            [&](int t) { return group->taken[static_cast<std::size_t>(t)]; });
      });
      Group* into = free == groups_.end() ? nullptr : free->get();
      if (!into) {
        into = groups_.emplace_back(std::make_unique<Group>()).get();
        into->shape = shape;
        into->taken.assign(static_cast<std::size_t>(term_count()) + columns_.size(), 0);
      }
      into->members.push_back(k);
      for (int t : terms) into->taken[static_cast<std::size_t>(t)] = 1;
    }
  for (const auto& group : groups_)
    for (const Offset& offset : offsets(group->shape))
      group->drawings.push_back(draw(group->members, std::vector<double>(group->members.size(), offset.steps)));
}

std::unique_ptr<ParameterTerms> ParameterTerms::find(const ParametricScene& scene,
                                                     const std::vector<DesignParameter>& parameters,
                                                     const Drawing& nominal, const std::vector<State>& probes,
                                                     const std::vector<Drawing::Place>& columns, bool with_start,
                                                     std::string& why) {
  const System& system = nominal.system();
  const Layout& layout = system.layout();
  Search search;
  read_drawn(system.graph(), layout, search.drawn_q, search.drawn_v);
  VectorX d(layout.v_count());
  layout.difference(search.drawn_q, system.initial_state().q, d);
  if (with_start && (largest_entry(d) > kSamePlace || largest_entry(system.initial_state().v - search.drawn_v) >
                                                          kSamePlace * (1 + largest_entry(search.drawn_v)))) {
    why = "the drawing does not stand on its joints";
    return nullptr;
  }
  std::unique_ptr<ParameterTerms> found(new ParameterTerms(scene, parameters, nominal, probes, columns));
  std::mt19937 random(7);
  const auto count = static_cast<Eigen::Index>(probes.size());
  search.nominal.resize(found->term_count(), 3 * count);
  search.sizes = search.nominal;
  search.columns.resize(static_cast<Eigen::Index>(columns.size()) * count);
  search.start_apart.assign(parameters.size(), 0);
  MatrixX values, sizes;
  Snapshot now(system);
  for (Eigen::Index i = 0; i < count; ++i) {
    // Nearby, so that terms do not vanish by chance.
    State& state = found->probes_[static_cast<std::size_t>(i)];
    state.v_dot.conservativeResize(layout.v_count());
    state.lambda.conservativeResize(layout.row_count());
    layout.retract(state.q, 1e-2 * random_entries(random, layout.v_count()), state.q);
    for (VectorX* x : {&state.v, &state.v_dot, &state.lambda})
      *x += 0.3 * (1 + largest_entry(*x)) * random_entries(random, x->size());
    using Rows = WeightedSum::Rows;
    for (const Rows rows : {Rows::position, Rows::velocity, Rows::acceleration}) {
      const auto at = static_cast<Eigen::Index>(search.looks.size());
      const MatrixX mu = random_entries(random, layout.v_count()), nu = random_entries(random, layout.row_count());
      const Search::Look& look =
          search.looks.emplace_back(Search::Look{static_cast<std::size_t>(i),
                                                 {rows, true, state.v_dot, state.lambda, {}},
                                                 rows == Rows::position ? mu : MatrixX(layout.v_count(), 0),
                                                 nu});
      found->terms(found->equations_, state, look.sum, look.mu, look.nu, values, &sizes);
      search.nominal.col(at) = values;
      search.sizes.col(at) = sizes;
    }
    now.evaluate(state, Accelerations::solved);
    for (std::size_t c = 0; c < columns.size(); ++c)
      search.columns[static_cast<Eigen::Index>(c) * count + i] =
          nominal.sensor(columns[c].sensor).value(now, columns[c].column);
  }

  std::map<std::string, std::vector<int>> kinds;
  for (int k = 0; k < found->count(); ++k) kinds[kind_of(parameters[static_cast<std::size_t>(k)].name)].push_back(k);
  std::vector<std::vector<int>> open;
  for (const auto& [name, members] : kinds) open.push_back(members);
  while (!open.empty()) {
    const std::vector<int> members = std::move(open.back());
    open.pop_back();
    if (found->decode(members, search)) continue;
    if (members.size() == 1) {
      why = "the equations do not change smoothly with the parameter '" +
            parameters[static_cast<std::size_t>(members.front())].name + "'";
      return nullptr;
    }
    std::vector<int> halves[2];
    for (std::size_t i = 0; i < members.size(); ++i) halves[i % 2].push_back(members[i]);
    for (auto& half : halves) open.push_back(std::move(half));
  }
  for (int k = 0; k < found->count(); ++k)
    if (with_start && search.start_apart[static_cast<std::size_t>(k)]) found->difference_start(k);
  found->gather();
  return found;
}

void ParameterTerms::add_products(const State& state, const WeightedSum& sum, const MatrixX& mu, const MatrixX& nu,
                                  double factor, MatrixX& gradient) {
  terms(equations_, state, sum, mu, nu, nominal_terms_);
  for (const auto& group : groups_) {
    change_.setZero(nominal_terms_.rows(), nominal_terms_.cols());
    double of_nominal = 0;
    const auto offsets_of = offsets(group->shape);
    for (std::size_t i = 0; i < offsets_of.size(); ++i) {
      terms(group->drawings[i]->equations, state, sum, mu, nu, values_);
      change_ += offsets_of[i].weight * values_;
      of_nominal -= offsets_of[i].weight;
    }
    change_ += of_nominal * nominal_terms_;
    for (int k : group->members) {
      const double scale = factor / parameters_[static_cast<std::size_t>(k)].step;
      for (int t : touched_[static_cast<std::size_t>(k)])
        if (t < term_count()) gradient.row(k) += scale * change_.row(t);
    }
  }
}

void ParameterTerms::sensor(int column, const State& state, VectorX& out) {
  out.setZero(count());
  const Drawing::Place& place = columns_[static_cast<std::size_t>(column)];
  double nominal = 0;
  bool looked = false;
  for (const auto& group : groups_) {
    if (!group->taken[static_cast<std::size_t>(term_count() + column)]) continue;
    if (!looked) {
      Snapshot now(nominal_.system());
      now.evaluate(state, Accelerations::solved);
      nominal = nominal_.sensor(place.sensor).value(now, place.column);
      looked = true;
    }
    double value = 0;
    const auto offsets_of = offsets(group->shape);
    for (std::size_t i = 0; i < offsets_of.size(); ++i)
      value += offsets_of[i].weight * (group->drawings[i]->value(place, state) - nominal);
    for (int k : group->members) {
      const auto& terms = touched_[static_cast<std::size_t>(k)];
      if (std::find(terms.begin(), terms.end(), term_count() + column) != terms.end())
        out[k] = value / parameters_[static_cast<std::size_t>(k)].step;
    }
  }
}

void ParameterTerms::add_drawn(const MatrixX& turn, const MatrixX& velocity, MatrixX& gradient) const {
  for (int k = 0; k < count(); ++k)
    for (const Start& s : starts_[static_cast<std::size_t>(k)])
      gradient.row(k) += s.turn.transpose() * turn.middleRows(s.first, s.turn.size()) +
                         s.velocity.transpose() * velocity.middleRows(s.first, s.velocity.size());
}

}  // namespace lithe
