#include "engine/assembly/reached_state.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/assembly/batch_of.h"
#include "engine/assembly/evaluated.h"
#include "engine/assembly/lost_angles.h"
#include "engine/assembly/redundancy.h"
#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/factor/block_products.h"
#include "engine/model/limited_motion.h"

namespace lithe {
namespace {

constexpr double kOff = 1e-6;     // in the units of the rows
constexpr double kBeside = 1e3;   // of what the other rows are off by
constexpr double kShare = 1e-4;   // of a rate or acceleration: rows count as dependent up to a sine of 3e-5
constexpr double kNoRate = 1e-9;  // of 1 and the fastest velocity or acceleration: round-off

std::string size_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", value);
  return text;
}

double largest(const VectorX& x) { return x.size() > 0 ? x.cwiseAbs().maxCoeff() : 0; }

/// The first row left out that is off by more than allowed; -1: none.
template <class Allowed>
int find_row_off(const std::vector<int>& left_out, const VectorX& off, Allowed&& allowed) {
  double others = 0;
  for (int row = 0; row < off.size(); ++row)
    if (!std::binary_search(left_out.begin(), left_out.end(), row)) others = std::max(others, std::abs(off[row]));
  for (const int row : left_out)
    if (!(std::abs(off[row]) <= allowed(row) + kBeside * others)) return row;
  return -1;
}

}  // namespace

const char* const kContradictionFix =
    "remove one of them, or make them agree: drives of one motion need one law, joints that close one loop lengths and "
    "axes that fit";

ReachedState::ReachedState(Evaluator& evaluator) : evaluator_(evaluator) {}
ReachedState::~ReachedState() = default;

std::unique_ptr<ReachedState> ReachedState::make(Evaluator& evaluator) {
  std::unique_ptr<ReachedState> made(new ReachedState(evaluator));
  for (const auto& entry : evaluator.system().graph().constraints())
    if (const auto* limits = dynamic_cast<const LimitedMotion*>(entry.constraint))
      made->limited_.push_back({entry.constraint, limits, entry.markers});
  if (evaluator.workspace().quarter_turns.size() > 0) made->angles_ = std::make_unique<LostAngles>(evaluator);
  if (made->limited_.empty() && evaluator.redundant_rows().empty() && !made->angles_) return nullptr;
  made->rows_.setZero(evaluator.layout().row_count());
  made->rates_ = made->rows_;
  return made;
}

std::string ReachedState::beyond_limit(const Limited& limited) {
  markers_.clear();
  for (const Marker& marker : limited.markers)
    markers_.push_back(marker_kinematics(evaluator_, marker, Level::position));
  return limited.limits->beyond_limit(connector::Views(markers_.data(), static_cast<int>(markers_.size())))
      .value_or("");
}

int ReachedState::find_row() {
  const std::vector<int>&left_out = evaluator_.redundant_rows(), &on_velocities = evaluator_.velocity_rows();
  if (left_out.empty()) return -1;
  evaluator_.constraint(Level::position, rows_);
  const int row = find_row_off(left_out, rows_, [](int) { return kOff; });
  if (row >= 0 || on_velocities.empty()) return row;
  evaluator_.constraint(Level::velocity, rates_);
  rows_.setZero();
  for (const int r : on_velocities) rows_[r] = rates_[r];
  return find_row_off(left_out, rows_, [&](int) { return kOff * (1 + largest(evaluator_.workspace().v)); });
}

bool ReachedState::loses_angle(const State& state) { return angles_ && angles_->loses(state); }

void ReachedState::check(const State& state) {
  if (angles_) angles_->check(state);
  if (limited_.empty() && evaluator_.redundant_rows().empty()) return;
  // By forward dynamics nothing was evaluated, and nothing can be off: it takes lower pairs alone, which no drive
  // moves, closes their loops itself, and keeps bodies in the planes across which rows are left out.
  if (evaluator_.evaluations() == evaluations_ && evaluator_.parts().forward_dynamics) return;
  const bool evaluated = evaluator_.evaluations() != evaluations_ && evaluator_.velocity_rows().empty();
  evaluations_ = evaluator_.evaluations();
  const auto is_beyond = [&](const Limited& limited) { return !beyond_limit(limited).empty(); };
  if (evaluated && std::ranges::none_of(limited_, is_beyond)) {
    evaluator_.constraint(Level::position, rows_);
    if (std::ranges::all_of(evaluator_.redundant_rows(), [&](int row) { return std::abs(rows_[row]) <= kOff; })) return;
  }
  evaluator_.evaluate(state.time, state.q, state.v,
                      evaluator_.velocity_rows().empty() ? Level::position : Level::velocity);
  evaluations_ = evaluator_.evaluations();
  for (const Limited& limited : limited_)
    if (const std::string beyond = beyond_limit(limited); !beyond.empty())
      throw SimulationError("'" + limited.joint->name() + "' " + beyond + " at " + time_text(state.time),
                            limited.joint->where(),
                            "keep it within: stops, springs or other joints; or take a joint that has no such limit");
  const int row = find_row();
  if (row < 0) return;
  const double off = rows_[row];
  throw SimulationError(
      contradiction(evaluator_, row) + " is off by " + size_text(off) + " at " + time_text(state.time),
      "the constraints at " + time_text(state.time), kContradictionFix);
}

void ReachedState::check_start(const State& start) {
  const std::vector<int>& left_out = evaluator_.redundant_rows();
  if (left_out.empty()) return;
  const Workspace& work = evaluator_.workspace();
  const auto& blocks = evaluator_.system().blocks();
  const auto refuse = [&](int row, const char* what) {
    const double off = rows_[row];
    throw SceneError(contradiction(evaluator_, row) + " has " + what + size_text(off) + " at " + time_text(start.time),
                     "assemble", kContradictionFix);
  };
  evaluator_.evaluate(start.time, start.q, start.v, Level::acceleration);
  // ∂g/∂t and G v, which are to cancel.
  rates_.setZero();
  add_rates(blocks, work.values, start.v.data(), rates_);
  rows_ = rates_ + work.rate;
  int row = find_row_off(left_out, rows_, [&](int r) {
    return kShare * (std::abs(rates_[r]) + std::abs(work.rate[r])) + kNoRate * (1 + largest(start.v));
  });
  if (row >= 0) refuse(row, "a rate that is off by ");
  // G v̇ and the velocity terms.
  rates_.setZero();
  add_rates(blocks, work.values, start.v_dot.data(), rates_);
  rows_ = rates_ + work.bias;
  row = find_row_off(left_out, rows_, [&](int r) {
    return kShare * (std::abs(rates_[r]) + std::abs(work.bias[r])) +
           kNoRate * (1 + largest(start.v_dot) + start.v.squaredNorm());
  });
  if (row >= 0) refuse(row, "an acceleration that is off by ");
}

std::string contradiction(Evaluator& evaluator, int row) {
  constexpr double kInvolved = 1e-3;  // of the largest share in the null vector
  constexpr std::size_t kNamed = 4;
  const Layout& layout = evaluator.layout();
  const Workspace& work = evaluator.workspace();
  const VectorX still = VectorX::Zero(layout.v_count()), no_load = VectorX::Zero(layout.row_count());
  const std::vector<int> before = evaluator.redundant_rows();
  evaluator.factorize({0, 0, 1}, still, no_load, nullptr);
  int left_out = row;  // or, where it has just been exchanged, the one that is so instead of it
  for (const int r : evaluator.redundant_rows())
    if (!std::binary_search(before.begin(), before.end(), r)) left_out = r;
  // Scales are of rows of forces too.
  const VectorX share =
      null_vector(evaluator, left_out).cwiseProduct(evaluator.system().row_scales().head(layout.row_count()));
  const bool known = share.allFinite();  // else rows have lost rank here
  const double least = known ? kInvolved * share.cwiseAbs().maxCoeff() : 0;
  // Those that prescribe motion, if there are two; else all.
  std::vector<std::string> all, driving;
  for (const auto& rows : layout.rows()) {
    if (rows.count == 0) continue;
    const auto its = [&](const VectorX& x) { return x.segment(rows.first, rows.count).cwiseAbs().maxCoeff(); };
    const bool own = rows.first <= row && row - rows.first < rows.count;
    const bool drives = its(work.rate) > 0;
    if (!own && !(known ? its(share) > least : drives)) continue;
    all.push_back("'" + rows.name + "'");
    if (own || drives) driving.push_back(all.back());
  }
  const std::vector<std::string>& named = driving.size() > 1 ? driving : all;
  std::string text;
  for (std::size_t i = 0; i < std::min(kNamed, named.size()); ++i)
    text += (i == 0 ? "" : i + 1 == named.size() ? " and " : ", ") + named[i];
  if (named.size() > kNamed) text += " and " + std::to_string(named.size() - kNamed) + " more";
  text += named.size() > 1 ? std::string(" ") + kContradict + ": " : " restrains nothing and does not hold: ";
  return text + layout.row_name(row) + ", which is left out,";
}

}  // namespace lithe
