#include "bodies/flexible/fatigue_recorder.h"

#include <algorithm>
#include <numeric>

#include "bodies/flexible/deformation_writer.h"
#include "engine/archive/archive.h"
#include "engine/base/checks.h"

namespace lithe {
namespace {

/// What a node, or one plane at a node, has come by.
struct FatigueCount {
  RainflowCounter counter{};
  double cycles = 0, largest_range = 0, damage = 0;
};

/// Normals on a half sphere, rings 7.5 degrees apart, as weights of xx yy zz xy xz yz in nᵀ σ n.
MatrixX planes() {
  constexpr int kRings = 12;
  const double step = M_PI / 2 / kRings;
  std::vector<Vector3> normals{{0, 0, 1}};
  for (int ring = 1; ring <= kRings; ++ring) {
    // At the equator half a turn: the other half are the same planes.
    const int around = static_cast<int>(std::ceil(4 * kRings * std::sin(ring * step))),
              last = ring == kRings ? around / 2 : around;
    for (int k = 0; k < last; ++k) {
      const double phi = 2 * M_PI * k / around;
      normals.emplace_back(std::sin(ring * step) * std::cos(phi), std::sin(ring * step) * std::sin(phi),
                           std::cos(ring * step));
    }
  }
  MatrixX weights(static_cast<Eigen::Index>(normals.size()), 6);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const Vector3& n = normals[i];
    weights.row(static_cast<Eigen::Index>(i)) << n[0] * n[0], n[1] * n[1], n[2] * n[2], 2 * n[0] * n[1],
        2 * n[0] * n[2], 2 * n[1] * n[2];
  }
  return weights;
}

double signed_von_mises(const Vector6& stress) {
  const Vector3 sigma = principal(stress);
  return (sigma[0] + sigma[2] < 0 ? -1 : 1) * von_mises(stress)[0];
}

/// Of each node, of each plane. values(s): planes x nodes at state s; where(i): node i, for errors.
template <class Values, class Where>
std::vector<std::vector<FatigueCount>> counted(const Values& values, std::size_t states, const SnCurve& curve,
                                               const Where& where) {
  std::vector<std::vector<FatigueCount>> counts;
  // visit(count, take, node, plane): take() notes a cycle.
  const auto at_each = [&](auto&& visit) {
    for (std::size_t i = 0; i < counts.size(); ++i) try {
        for (std::size_t plane = 0; plane < counts[i].size(); ++plane) {
          FatigueCount& count = counts[i][plane];
          const auto take = [&](const LoadCycle& cycle) {
            count.cycles += cycle.count;
            count.largest_range = std::max(count.largest_range, cycle.range);
            count.damage += curve.damage(cycle);
          };
          visit(count, take, i, plane);
        }
      } catch (const SceneError& error) {
        throw SceneError(error.problem(), where(i), error.fix());
      }
  };
  for (std::size_t s = 0; s < states; ++s) {
    const MatrixX now = values(s);
    counts.resize(static_cast<std::size_t>(now.cols()),
                  std::vector<FatigueCount>(static_cast<std::size_t>(now.rows())));
    at_each([&](FatigueCount& count, const auto& take, std::size_t i, std::size_t plane) {
      count.counter.add(now(static_cast<Eigen::Index>(plane), static_cast<Eigen::Index>(i)), take);
    });
  }
  at_each([](FatigueCount& count, const auto& take, std::size_t, std::size_t) { count.counter.finish(take); });
  return counts;
}

}  // namespace

FatigueRecorder::FatigueRecorder(const FlexibleBody& body, std::shared_ptr<const StressRecovery> recovery)
    : stress_(body, std::move(recovery)) {}

void FatigueRecorder::observe(Snapshot& snapshot) {
  if (!times_.empty() && snapshot.time() == times_.back()) return;  // told twice of one instant: at an event
  if (!times_.empty() && snapshot.time() < times_.back()) times_.clear(), coordinates_.clear();
  const VectorX now = stress_.coordinates(snapshot);
  times_.push_back(snapshot.time());
  coordinates_.insert(coordinates_.end(), now.begin(), now.end());
}

void FatigueRecorder::history(Archive& archive) {
  archive("times", times_);
  archive("coordinates", coordinates_);
}

Table FatigueRecorder::table(const FatigueCriterion& criterion) const {
  const FlexibleBody& body = stress_.body();
  const ModalBasis& basis = body.basis();
  const std::string where = "fatigue of '" + body.name() + "' of " + body.where();
  require::at(where, [&] { criterion.curve.check(); });
  if (times_.size() < 2)
    throw SceneError("there are " + std::to_string(times_.size()) + " observed states", where,
                     "call simulation.observe(fatigue, every(...)) and run first");
  std::vector<int> nodes(static_cast<std::size_t>(basis.nodes.cols()));
  std::iota(nodes.begin(), nodes.end(), 0);
  if (!criterion.nodes.empty()) {
    nodes.clear();
    for (const int id : criterion.nodes) nodes.push_back(basis.node_index(id));
  }
  const auto label = [&](std::size_t i) { return basis.node_ids[static_cast<std::size_t>(nodes[i])]; };

  const bool by_planes = criterion.stress == FatigueStress::critical_plane;
  const MatrixX normals = by_planes ? planes() : MatrixX();
  const auto width = static_cast<Eigen::Index>(coordinates_.size() / times_.size());
  const auto values = [&](std::size_t state) -> MatrixX {
    const VectorX coordinates =
        Eigen::Map<const VectorX>(coordinates_.data() + static_cast<Eigen::Index>(state) * width, width);
    const Matrix6X stress = stress_.stress(coordinates)(Eigen::all, nodes);
    if (by_planes) return normals * stress;
    MatrixX signed_stress(1, stress.cols());
    for (Eigen::Index i = 0; i < stress.cols(); ++i) signed_stress(0, i) = signed_von_mises(stress.col(i));
    return signed_stress;
  };
  const auto counts = counted(values, times_.size(), criterion.curve,
                              [&](std::size_t i) { return where + ", node " + std::to_string(label(i)); });

  Table table{.columns = {"node", "cycles", "largest_range", "damage", "life"}};
  const double duration = times_.back() - times_.front();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const FatigueCount& worst =
        *std::max_element(counts[i].begin(), counts[i].end(), [](const FatigueCount& a, const FatigueCount& b) {
          return std::pair(a.damage, a.largest_range) < std::pair(b.damage, b.largest_range);
        });
    table.add_row({static_cast<double>(label(i)), worst.cycles, worst.largest_range, worst.damage,
                   worst.damage > 0 ? std::min(duration / worst.damage, kEndless) : kEndless});
  }
  return table;
}

VectorX FatigueRecorder::at_nodes(const Table& table, const std::string& column) const {
  const ModalBasis& basis = stress_.body().basis();
  VectorX values = VectorX::Zero(basis.nodes.cols());
  const std::vector<double> nodes = table.column("node"), of_table = table.column(column);
  for (std::size_t i = 0; i < nodes.size(); ++i) values[basis.node_index(static_cast<int>(nodes[i]))] = of_table[i];
  return values;
}

void FatigueRecorder::write_vtu(const std::string& path, const Table& table) const {
  const ModalBasis& basis = stress_.body().basis();
  lithe::write_vtu(path, mesh_nodes(basis), vtu_cells(basis),
                   {{"damage", at_nodes(table, "damage").transpose()},
                    {"largest_range", at_nodes(table, "largest_range").transpose()}});
}

}  // namespace lithe
