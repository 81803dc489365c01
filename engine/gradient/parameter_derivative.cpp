#include "engine/gradient/parameter_derivative.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/gradient/contact_numbers.h"
#include "engine/gradient/differences.h"

namespace lithe {

namespace {

constexpr int kFew = kFewParameters;
constexpr double kLinear = 1e-11;    // two differences agree as well as this: the step does not matter
constexpr double kSmooth = 1e-2;     // they disagree by more: the scene jumps with the parameter
constexpr double kRoundOff = 1e-12;  // of what is differenced
constexpr double kStrange = 1e-9;    // of a group's largest change, in rows that no member changes

constexpr std::array<double, 2> kLinearWeights{0.5, -0.5};  // of the first two, where f is linear in p

VectorX random_vector(std::mt19937& random, Eigen::Index size) {
  VectorX x(size);
  for (double& value : x) value = static_cast<double>(random()) / 2147483648.0 - 1;
  return x;
}

}  // namespace

/// The scene with some parameters moved.
struct ParameterDerivative::Moved : MovedDrawing {
  using MovedDrawing::MovedDrawing;
  /// r, then the rows, then ġ.
  void residual(const State& state, VectorX& out) {
    const int velocities = equations.layout().v_count(), rows = equations.layout().row_count();
    out.resize(velocities + 2 * rows);
    equations.recall(state.quarter_turns);
    equations.evaluate(state.time, state.q, state.v, Level::velocity);
    equations.residual(state.v_dot, state.lambda, out.head(velocities));
    equations.constraint(Level::position, out.segment(velocities, rows));
    equations.constraint(Level::velocity, out.tail(rows));
    for (int row : equations.velocity_rows()) out[velocities + row] = out[velocities + rows + row];
  }
};

/// Parameters that are moved together.
struct ParameterDerivative::Group {
  std::vector<int> members;
  std::vector<std::vector<int>> rows;            // of each member; of one alone: empty, all
  std::vector<std::unique_ptr<Moved>> drawings;  // at kOffsets, or at the first two
  std::vector<char> claimed;                     // rows of several members: no other may change
  double weight(std::size_t i) const { return drawings.size() == 2 ? kLinearWeights[i] : kOffsets[i].weight; }
};

std::unique_ptr<ParameterDerivative::Moved> ParameterDerivative::draw(const std::vector<int>& members,
                                                                      double steps) const {
  const log::Quiet quiet;
  std::vector<DesignParameter> values = parameters_;
  for (int k : members) {
    DesignParameter& p = values[static_cast<std::size_t>(k)];
    p.value += steps * p.step;
  }
  auto drawn = std::make_unique<Moved>(scene_, values);
  const Layout &layout = drawn->equations.layout(), &as_drawn = nominal_.system().layout();
  if (layout.q_count() != as_drawn.q_count() || layout.v_count() != as_drawn.v_count() ||
      layout.row_count() != as_drawn.row_count())
    throw SceneError("the parameter '" + parameters_[static_cast<std::size_t>(members.front())].name +
                         "' changes which coordinates or rows there are",
                     "scene '" + scene_.name + "'", "keep the elements the same for all values of a parameter");
  return drawn;
}

ParameterDerivative::ParameterDerivative(const ParametricScene& scene, std::vector<DesignParameter> parameters,
                                         const Drawing& nominal, const std::vector<State>& probes,
                                         std::vector<Drawing::Place> columns, Grouping grouping)
    : scene_(scene),
      parameters_(std::move(parameters)),
      nominal_(nominal),
      probes_(probes),
      columns_(std::move(columns)),
      seen_(columns_.size(), false) {
  // States nearby, so that terms do not vanish by chance; as near as the equations want them.
  std::mt19937 random(7);
  const Layout& layout = nominal.system().layout();
  Moved as_drawn(scene, parameters_);
  for (State& state : probes_) {
    VectorX& rows = nominal_rows_.emplace_back();
    const State probe = state;
    for (double aside = 1; rows.size() == 0; aside *= 0.1) {
      layout.retract(probe.q, 1e-2 * aside * random_vector(random, layout.v_count()), state.q);
      for (const auto part : {&State::v, &State::v_dot, &State::lambda})
        state.*part =
            probe.*part + 0.3 * aside * (1 + largest_entry(probe.*part)) * random_vector(random, (probe.*part).size());
      try {
        as_drawn.residual(state, rows);
      } catch (const SimulationError&) {
        if (aside < 1e-4) throw;
        rows.resize(0);
      }
    }
  }
  const bool touches = !nominal.system().contacts().empty();  // which parameters contacts know the probes may not show
  const bool few = grouping == Grouping::apart || count() <= kFew || touches;

  std::vector<std::vector<char>> taken;  // rows of each group
  std::vector<char> linear_group;
  for (int k = 0; k < count(); ++k) {
    std::vector<std::unique_ptr<Moved>> drawings;
    for (const Offset& offset : kOffsets) drawings.push_back(draw({k}, offset.steps));
    difference_start(k, drawings);
    check_smooth(k, drawings);
    const bool seen = is_seen(*drawings.front());
    bool linear = !seen && !touches;
    for (const std::vector<State>* states : {&std::as_const(probes_), &probes})  // far away laws may be straight
      for (const State& state : *states) {
        if (!linear) break;
        std::array<VectorX, 4> r;
        for (int j = 0; j < 4; ++j) drawings[static_cast<std::size_t>(j)]->residual(state, r[j]);
        linear = largest_entry(r[2] - r[3] - 2 * (r[0] - r[1])) <=
                 kLinear * largest_entry(r[0] - r[1]) + 1e-15 * largest_entry(r[0]);
      }
    if (few || seen) {
      auto& group = *groups_.emplace_back(std::make_unique<Group>());
      group.members = {k};
      group.rows = {{}};
      if (linear && grouping != Grouping::apart) drawings.resize(2);
      group.drawings = std::move(drawings);
      taken.emplace_back();
      linear_group.push_back(linear);
      continue;
    }
    // The first group with the rows free.
    std::vector<int> rows = rows_of(*drawings.front());
    std::size_t g = 0;
    for (; g < groups_.size(); ++g)
      if (!taken[g].empty() && linear_group[g] == static_cast<char>(linear) &&
          std::none_of(rows.begin(), rows.end(), [&](int row) { return taken[g][static_cast<std::size_t>(row)]; }))
        break;
    if (g == groups_.size()) {
      groups_.push_back(std::make_unique<Group>());
      taken.emplace_back(static_cast<std::size_t>(layout.v_count() + 2 * layout.row_count()), 0);
      linear_group.push_back(linear);
    }
    for (int row : rows) taken[g][static_cast<std::size_t>(row)] = 1;
    groups_[g]->members.push_back(k);
    groups_[g]->rows.push_back(std::move(rows));
  }
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    if (!groups_[g]->drawings.empty()) continue;
    if (groups_[g]->members.size() > 1) groups_[g]->claimed = taken[g];
    for (std::size_t i = 0; i < (linear_group[g] ? 2u : 4u); ++i)
      groups_[g]->drawings.push_back(draw(groups_[g]->members, kOffsets[i].steps));
  }
}

ParameterDerivative::~ParameterDerivative() = default;

/// Of the state and the history that start() leaves.
void ParameterDerivative::difference_start(int k, const std::vector<std::unique_ptr<Moved>>& drawings) {
  const Layout& layout = nominal_.system().layout();
  const State& base = nominal_.system().initial_state();
  const double h = parameters_[static_cast<std::size_t>(k)].step;
  VectorX turn = VectorX::Zero(layout.v_count()), velocity = turn, d(layout.v_count());
  MatrixX history, first_carried;
  VectorX first_v, memory, first_memory;
  for (std::size_t i = 0; i < drawings.size(); ++i) {
    State state = drawings[i]->drawing.system().initial_state();
    MatrixX carried;
    if (scene_.integrator) {
      const auto integrator = scene_.integrator();
      integrator->start(drawings[i]->equations, state);
      const auto& method = dynamic_cast<const DifferentiableSteps&>(*integrator);
      if (const auto derivative = method.step_derivative())
        carried = derivative->history(state);
      else if (const auto step = method.repeated_step(drawings[i]->equations))
        carried = step->history(state, nullptr);
    }
    const double weight = kOffsets[i].weight / h;
    layout.difference(base.q, state.q, d);
    turn += weight * d;
    const VectorX remembered = contact_numbers(state.contacts);
    if (i == 0) {
      first_v = state.v, first_carried = carried, first_memory = remembered;
      history.setZero(carried.rows(), carried.cols());
      memory.setZero(remembered.size());
    }
    if (remembered.size() != first_memory.size())
      throw SceneError("contacts that touch at the start do not with the parameter '" +
                           parameters_[static_cast<std::size_t>(k)].name + "' moved",
                       "scene '" + scene_.name + "'", "start with some overlap, or apart");
    memory += weight * (remembered - first_memory);
    velocity += weight * (state.v - first_v);  // the weights add up to zero
    history += weight * (carried - first_carried);
  }
  if (k == 0) {
    start_.turn.setZero(layout.v_count(), count());
    start_.velocity = start_.turn;
    start_.history.assign(static_cast<std::size_t>(history.cols()), start_.turn);
    start_.memory.setZero(memory.size(), count());
  }
  start_.memory.col(k) = memory;
  start_.turn.col(k) = turn;
  start_.velocity.col(k) = velocity;
  for (std::size_t i = 0; i < start_.history.size(); ++i)
    start_.history[i].col(k) = history.col(static_cast<Eigen::Index>(i));
}

/// Rows of the equations that a moved parameter changes.
std::vector<int> ParameterDerivative::rows_of(const Moved& drawing) const {
  std::vector<int> rows;
  VectorX r;
  for (std::size_t i = 0; i < probes_.size(); ++i) {
    const_cast<Moved&>(drawing).residual(probes_[i], r);
    for (int row = 0; row < r.size(); ++row)
      if (r[row] != nominal_rows_[i][row]) rows.push_back(row);
  }
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

bool ParameterDerivative::is_seen(Moved& drawing) {
  bool any = false;
  Snapshot now(nominal_.system());
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    const Drawing::Place& place = columns_[c];
    for (const State& state : probes_) {
      now.evaluate(state, Accelerations::solved);
      if (nominal_.sensor(place.sensor).value(now, place.column) == drawing.value(place, state)) continue;
      seen_[c] = any = true;
      break;
    }
  }
  return any;
}

/// The two differences must agree, or the drawing jumps: a mode of a reduced body that changes its sign or its place.
void ParameterDerivative::check_smooth(int k, std::vector<std::unique_ptr<Moved>>& drawings) const {
  std::array<VectorX, 4> r;
  for (const State& state : probes_) {
    for (std::size_t i = 0; i < 4; ++i) drawings[i]->residual(state, r[i]);
    const VectorX one = (r[0] - r[1]) / 2, two = (r[2] - r[3]) / 4;
    if (largest_entry(one - two) <= kSmooth * largest_entry(one) + kRoundOff * largest_entry(r[0])) continue;
    const std::string& name = parameters_[static_cast<std::size_t>(k)].name;
    throw SceneError("the equations do not change smoothly with the parameter '" + name + "'",
                     "scene '" + scene_.name + "'",
                     "give it a smaller step; reduce a flexible body by modes that keep their order and sign");
  }
}

/// Calls take(group, derivative of (r, rows) along the group's parameters, times their steps).
template <class Take>
void ParameterDerivative::difference(const State& state, const Take& take) {
  for (const auto& group : groups_) {
    // In pairs, so that what no parameter moves gives zero to the bit.
    for (std::size_t i = 0; i < group->drawings.size(); i += 2) {
      group->drawings[i]->residual(state, part_);
      group->drawings[i + 1]->residual(state, other_);
      part_ -= other_;
      if (i == 0) difference_.setZero(part_.size());
      difference_ += group->weight(i) * part_;
    }
    const double much = kStrange * largest_entry(difference_);
    for (std::size_t row = 0; row < group->claimed.size(); ++row)
      if (!group->claimed[row] && std::abs(difference_[static_cast<Eigen::Index>(row)]) > much)
        throw SimulationError("at t = " + std::to_string(state.time) + " s one of " +
                                  std::to_string(group->members.size()) + " parameters, '" +
                                  parameters_[static_cast<std::size_t>(group->members.front())].name +
                                  "' among them, changes equations that it did not change before",
                              "scene '" + scene_.name + "'",
                              "ask for the gradient of fewer parameters at once: up to " + std::to_string(kFew) +
                                  " are moved one by one");
    take(*group, difference_);
  }
}

void ParameterDerivative::columns(const State& state, MatrixX& force, MatrixX& rows, MatrixX* rates) {
  const Eigen::Index velocities = state.v.size(), row_count = state.lambda.size();
  force.setZero(velocities, count());
  rows.setZero(row_count, count());
  if (rates) rates->setZero(row_count, count());
  difference(state, [&](const Group& group, const VectorX& change) {
    for (std::size_t m = 0; m < group.members.size(); ++m) {
      const int k = group.members[m];
      const double scale = 1 / parameters_[static_cast<std::size_t>(k)].step;
      if (group.rows[m].empty() && group.members.size() == 1) {
        force.col(k) = scale * change.head(velocities);
        rows.col(k) = scale * change.segment(velocities, row_count);
        if (rates) rates->col(k) = scale * change.tail(row_count);
        continue;
      }
      for (int row : group.rows[m]) {
        if (row < velocities + row_count)
          (row < velocities ? force(row, k) : rows(row - velocities, k)) = scale * change[row];
        else if (rates)
          (*rates)(row - velocities - row_count, k) = scale * change[row];
      }
    }
  });
}

void ParameterDerivative::add_products(const State& state, const VectorX& mu, const VectorX& nu, VectorX& out) {
  const Eigen::Index velocities = mu.size();
  difference(state, [&](const Group& group, const VectorX& change) {
    for (std::size_t m = 0; m < group.members.size(); ++m) {
      const int k = group.members[m];
      double sum = 0;
      if (group.rows[m].empty() && group.members.size() == 1)
        sum = mu.dot(change.head(velocities)) + nu.dot(change.segment(velocities, nu.size()));
      for (int row : group.rows[m])
        if (row < velocities + nu.size()) sum += (row < velocities ? mu[row] : nu[row - velocities]) * change[row];
      out[k] += sum / parameters_[static_cast<std::size_t>(k)].step;
    }
  });
}

void ParameterDerivative::visit(int k, const std::function<void(Evaluator&, double weight)>& look) {
  Group& group = *groups_[static_cast<std::size_t>(k)];
  for (std::size_t i = 0; i < group.drawings.size(); ++i)
    look(group.drawings[i]->equations, group.weight(i) / parameters_[static_cast<std::size_t>(k)].step);
}

void ParameterDerivative::sensor(int column, const State& state, VectorX& out) {
  out.setZero(count());
  if (!seen_by(column)) return;
  const Drawing::Place& place = columns_[static_cast<std::size_t>(column)];
  for (const auto& group : groups_) {
    if (group->members.size() != 1 || !group->rows.front().empty()) continue;
    double sum = 0;
    for (std::size_t i = 0; i < group->drawings.size(); ++i)
      sum += group->weight(i) * group->drawings[i]->value(place, state);
    out[group->members.front()] = sum / parameters_[static_cast<std::size_t>(group->members.front())].step;
  }
}

}  // namespace lithe
