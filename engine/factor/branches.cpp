#include "engine/factor/branches.h"

#include <algorithm>
#include <numeric>
#include <queue>

namespace lithe {
namespace {

constexpr double kWorthwhile = 3e4;  // multiplications: some ten microseconds, below which threads only wait
constexpr int kPieces = 16;          // a subtree of less than this share of the work is not cut further
constexpr double kTrunk = 0.05;      // most of the work that goes to the trunk
constexpr double kHeaviest = 0.75;   // of one branch: with more, a second thread has nothing to do

/// The tree of an elimination with the work of its subtrees.
class Tree {
 public:
  Tree(const Elimination& elimination, const std::vector<double>& work)
      : own_(work), work_(work), children_(work.size()), place_(work.size()) {
    const auto& order = elimination.order;
    const std::vector<int> parent = parents(elimination);
    for (std::size_t i = 0; i < order.size(); ++i) {
      const int v = order[i];
      place_[v] = static_cast<int>(i);
      if (parent[v] < 0) {
        roots_.push_back(v);
      } else {
        children_[parent[v]].push_back(v);
        work_[parent[v]] += work_[v];
      }
    }
    total_ = std::accumulate(work.begin(), work.end(), 0.0);
  }

  double total() const { return total_; }

  /// Vertices whose subtrees are the pieces to share, in the order.
  std::vector<int> pieces() const {
    const auto lighter = [&](int a, int b) { return work_[a] < work_[b]; };
    std::priority_queue<int, std::vector<int>, decltype(lighter)> open(lighter, roots_);
    std::vector<int> found;
    double trunk = 0;
    while (!open.empty()) {
      const int v = open.top();
      open.pop();
      double cut = 0;
      std::vector<int> parts;
      if (work_[v] > total_ / kPieces) parts = split(v, kTrunk * total_ - trunk, cut);
      if (parts.empty()) found.push_back(v);
      trunk += cut;
      for (int part : parts) open.push(part);
    }
    std::sort(found.begin(), found.end(), [&](int a, int b) { return place_[a] < place_[b]; });
    return found;
  }

  double work(int v) const { return work_[v]; }
  /// The vertices of a subtree, in the order: they follow each other there.
  std::vector<int> vertices(int root) const {
    std::vector<int> all{root};
    for (std::size_t i = 0; i < all.size(); ++i)
      all.insert(all.end(), children_[all[i]].begin(), children_[all[i]].end());
    std::sort(all.begin(), all.end(), [&](int a, int b) { return place_[a] < place_[b]; });
    return all;
  }

 private:
  /// Follows the tree from v to where it branches into parts that are worth sharing; all parts there and on the way.
  /// None: there is no such place, or the vertices before it are more than `most` work. `cut`: theirs.
  std::vector<int> split(int v, double most, double& cut) const {
    std::vector<int> parts;
    double above = 0;
    for (;;) {
      above += own_[v];
      if (above > most || children_[v].empty()) return {};
      const auto heavier = [&](int a, int b) { return work_[a] < work_[b]; };
      const int heaviest = *std::max_element(children_[v].begin(), children_[v].end(), heavier);
      const double others = work_[v] - own_[v] - work_[heaviest];
      for (int child : children_[v])
        if (child != heaviest) parts.push_back(child);
      if (others > total_ / (4 * kPieces)) {
        parts.push_back(heaviest);
        cut = above;
        return parts;
      }
      v = heaviest;
    }
  }

  const std::vector<double>& own_;
  std::vector<double> work_;  // of the subtree
  std::vector<std::vector<int>> children_;
  std::vector<int> place_, roots_;
  double total_ = 0;
};

}  // namespace

std::vector<int> gather_branches(Elimination& elimination, const std::vector<double>& work) {
  const Tree tree(elimination, work);
  if (tree.total() < kWorthwhile) return {};
  // Small pieces side by side make one branch.
  std::vector<int> order, ends;
  double sum = 0, heaviest = 0;
  for (int piece : tree.pieces()) {
    const auto vertices = tree.vertices(piece);
    order.insert(order.end(), vertices.begin(), vertices.end());
    sum += tree.work(piece);
    if (sum < tree.total() / kPieces) continue;
    ends.push_back(static_cast<int>(order.size()));
    heaviest = std::max(heaviest, sum);
    sum = 0;
  }
  if (ends.size() < 2 || heaviest > kHeaviest * tree.total()) return {};
  order.resize(ends.back());
  std::vector<bool> gathered(work.size(), false);
  for (int v : order) gathered[v] = true;
  for (int v : elimination.order)
    if (!gathered[v]) order.push_back(v);
  elimination.order = std::move(order);
  return ends;
}

}  // namespace lithe
