#include "engine/factor/graph_topology.h"

#include <algorithm>
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/biconnected_components.hpp>
#include <boost/graph/connected_components.hpp>
#include <boost/graph/depth_first_search.hpp>
#include <boost/graph/graphviz.hpp>
#include <cmath>
#include <queue>
#include <set>
#include <sstream>

namespace lithe {
namespace {

using Graph = boost::adjacency_list<boost::vecS, boost::vecS, boost::undirectedS>;

/// Bodies, constraints, and (last) ground, where any constraint touches it.
Graph bipartite(const Topology& t) {
  Graph graph(t.body_count + t.ties.size() + 1);
  const auto ground = boost::num_vertices(graph) - 1;
  for (std::size_t c = 0; c < t.ties.size(); ++c)
    for (int body : t.ties[c])
      boost::add_edge(body < 0 ? ground : static_cast<std::size_t>(body), t.body_count + c, graph);
  return graph;
}

/// The part of the graph beyond each constraint that alone connects it with the rest: the interval of depth-first
/// discovery times of that part; empty where there is none.
struct Overhang {
  int begin = 0, end = 0;
  bool contains(int discovered) const { return discovered >= begin && discovered < end; }
  bool exists() const { return end > begin; }
};

class DepthFirstTimes : public boost::default_dfs_visitor {
 public:
  DepthFirstTimes(std::vector<int>& discovered, std::vector<int>& last, std::vector<int>& parent, int& clock)
      : discovered_(discovered), last_(last), parent_(parent), clock_(clock) {}
  template <class V, class G>
  void discover_vertex(V v, const G&) {
    discovered_[v] = clock_++;
  }
  template <class V, class G>
  void finish_vertex(V v, const G&) {
    last_[v] = clock_;
  }
  template <class E, class G>
  void tree_edge(E e, const G& g) {
    parent_[boost::target(e, g)] = static_cast<int>(boost::source(e, g));
  }

 private:
  std::vector<int>&discovered_, &last_, &parent_;
  int& clock_;
};

std::vector<Overhang> overhangs(const Topology& t, std::vector<int>& discovered) {
  const Graph graph = bipartite(t);
  const int n = static_cast<int>(boost::num_vertices(graph)), ground = n - 1;
  std::vector<int> last(n), parent(n, -1);
  discovered.assign(n, 0);
  int clock = 0;
  // From ground outwards, so that what lies beyond a constraint never contains ground; floating islands follow.
  boost::depth_first_search(graph,
                            boost::visitor(DepthFirstTimes(discovered, last, parent, clock)).root_vertex(ground));

  std::vector<std::size_t> cut;
  boost::articulation_points(graph, std::back_inserter(cut));
  std::vector<Overhang> beyond(t.ties.size());
  for (std::size_t v : cut) {
    if (static_cast<int>(v) < t.body_count || static_cast<int>(v) == ground) continue;
    if (boost::degree(v, graph) != 2 || parent[v] < 0) continue;
    for (auto [e, end] = boost::out_edges(v, graph); e != end; ++e) {
      const int w = static_cast<int>(boost::target(*e, graph));
      if (parent[w] == static_cast<int>(v)) beyond[v - t.body_count] = {discovered[w], last[w]};
    }
  }
  return beyond;
}

}  // namespace

namespace {

/// The same elimination with its order changed: a vertex after those that hang on it, walked from the leaves on.
void walk_tree(Elimination& elimination) {
  const int n = static_cast<int>(elimination.order.size());
  const std::vector<int> parent = parents(elimination);
  std::vector<std::vector<int>> children(n + 1);  // the last: of no vertex
  for (int v : elimination.order) children[parent[v] < 0 ? n : parent[v]].push_back(v);
  std::vector<int> order;
  order.reserve(n);
  std::vector<std::pair<int, std::size_t>> path{{n, 0}};
  while (!path.empty()) {
    auto& [v, next] = path.back();
    if (next < children[v].size()) {
      path.emplace_back(children[v][next++], 0);
    } else {
      if (v < n) order.push_back(v);
      path.pop_back();
    }
  }
  elimination.order = std::move(order);
}

}  // namespace

std::vector<int> parents(const Elimination& elimination) {
  std::vector<int> place(elimination.order.size()), parent(elimination.order.size(), -1);
  for (std::size_t i = 0; i < place.size(); ++i) place[elimination.order[i]] = static_cast<int>(i);
  for (int v : elimination.order) {
    const auto& around = elimination.neighbours[v];
    const auto next = std::min_element(around.begin(), around.end(), [&](int a, int b) { return place[a] < place[b]; });
    if (next != around.end()) parent[v] = *next;
  }
  return parent;
}

std::vector<int> islands(const Topology& t) {
  Graph graph(t.body_count);
  for (const auto& bodies : t.ties) {
    int first = -1;
    for (int body : bodies) {
      if (body < 0) continue;
      if (first >= 0) boost::add_edge(first, body, graph);
      first = body;
    }
  }
  std::vector<int> component(t.body_count);
  if (t.body_count > 0) boost::connected_components(graph, component.data());
  return component;
}

bool has_loops(const Topology& t) {
  const Graph graph = bipartite(t);
  std::vector<int> component(boost::num_vertices(graph));
  const int components = boost::connected_components(graph, component.data());
  return static_cast<int>(boost::num_edges(graph) + components) > static_cast<int>(boost::num_vertices(graph));
}

std::vector<int> centres(const Topology& t, const std::vector<int>& dimensions) {
  constexpr double kLarge =
      4e4;  // multiplications to invert its bodies' blocks, from which on threads can share a tree
  const int n = t.body_count + static_cast<int>(t.ties.size());
  std::vector<std::vector<int>> around(n);
  for (int c = t.body_count; c < n; ++c)
    for (int body : t.ties[c - t.body_count])
      if (body >= 0) around[body].push_back(c), around[c].push_back(body);
  std::vector<int> found, parent(n, -2), bodies(n, 0);  // parent: -2 not met, -1 a root; bodies at and beyond a vertex
  for (int root = 0; root < t.body_count; ++root) {
    if (parent[root] != -2) continue;
    std::vector<int> order{root};
    parent[root] = -1;
    std::size_t edges = 0;
    double work = 0;
    for (std::size_t i = 0; i < order.size(); ++i)
      for (int next : around[order[i]]) {
        ++edges;
        if (parent[next] != -2) continue;
        parent[next] = order[i];
        order.push_back(next);
      }
    if (edges != 2 * (order.size() - 1)) continue;  // each edge was met from both sides
    for (auto v = order.rbegin(); v != order.rend(); ++v) {
      if (*v < t.body_count) ++bodies[*v], work += std::pow(dimensions[*v], 3);
      if (parent[*v] >= 0) bodies[parent[*v]] += bodies[*v];
    }
    const int all = bodies[root];
    if (work < kLarge) continue;
    int best = root, largest = all;
    for (int v : order) {
      if (v >= t.body_count) continue;
      int part = all - bodies[v];
      for (int next : around[v])
        if (next != parent[v]) part = std::max(part, bodies[next]);
      if (part < largest) best = v, largest = part;
    }
    found.push_back(best);
  }
  return found;
}

Elimination plan_elimination(const Topology& t, const std::vector<int>& dimensions,
                             const std::vector<std::pair<int, int>>& couplings,
                             const std::vector<std::vector<int>>& first, const std::vector<int>& last) {
  const int bodies = t.body_count, others = bodies + static_cast<int>(t.ties.size()),
            n = others + static_cast<int>(first.size());
  std::vector<int> discovered;
  const std::vector<Overhang> beyond = overhangs(t, discovered);

  std::vector<std::set<int>> neighbours(n);
  std::vector<int> waiting(n, 0);  // bodies of a constraint that are still there
  const auto connect = [&](int a, int b) { neighbours[a].insert(b), neighbours[b].insert(a); };
  for (int c = bodies; c < others; ++c)
    for (int body : t.ties[c - bodies])
      if (body >= 0) connect(c, body), ++waiting[c];
  for (auto [a, b] : couplings)
    if (a != b) connect(a, b);

  const auto eligible = [&](int v) {
    if (v < bodies || waiting[v] == 0) return true;
    const Overhang& part = beyond[v - bodies];
    if (!part.exists() || waiting[v] > 1) return false;
    return std::none_of(neighbours[v].begin(), neighbours[v].end(),
                        [&](int w) { return part.contains(discovered[w]); });
  };
  const auto cost = [&](int v) {
    int sum = 0;
    for (int w : neighbours[v]) sum += dimensions[w];
    return sum;
  };
  std::vector<bool> waits(n, false);
  for (int v : last) waits[v] = true;
  // (last ones after all, cost, bodies of six numbers after constraints, number): those of three wait for nothing.
  // Entries outdated by later elimination are skipped when they come up.
  using Entry = std::tuple<bool, int, int, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  std::vector<int> queued(n, -1);
  const auto enqueue = [&](int v) {
    if (!eligible(v)) return;
    const int c = cost(v);
    if (queued[v] == c) return;
    queued[v] = c;
    queue.emplace(waits[v], c, v < bodies && dimensions[v] > 3, v);
  };
  Elimination elimination{{}, std::vector<std::vector<int>>(n)};
  std::vector<bool> done(n, false);
  elimination.order.reserve(n);
  for (int v = others; v < n; ++v) {
    elimination.order.push_back(v);
    elimination.neighbours[v] = first[v - others];
    std::sort(elimination.neighbours[v].begin(), elimination.neighbours[v].end());
    for (int a : elimination.neighbours[v])
      for (int b : elimination.neighbours[v])
        if (a < b) connect(a, b);
  }
  for (int v = others - 1; v >= 0; --v) enqueue(v);

  while (!queue.empty()) {
    const auto [waited, c, unused, v] = queue.top();
    queue.pop();
    if (done[v] || c != queued[v]) continue;
    done[v] = true;
    elimination.order.push_back(v);
    const std::vector<int>& around = elimination.neighbours[v];
    elimination.neighbours[v].assign(neighbours[v].begin(), neighbours[v].end());
    for (int a : around) {
      neighbours[a].erase(v);
      for (int b : around)
        if (a != b) neighbours[a].insert(b);
    }
    if (v < bodies)
      for (int a : around)
        if (a >= bodies && std::count(t.ties[a - bodies].begin(), t.ties[a - bodies].end(), v)) --waiting[a];
    for (int a : around) enqueue(a);
  }
  walk_tree(elimination);
  return elimination;
}

std::string graphviz(const GraphDrawing& drawing) {
  Graph graph(drawing.nodes.size());
  for (const auto& e : drawing.edges) boost::add_edge(e.from, e.to, graph);
  std::ostringstream out;
  boost::write_graphviz(out, graph, [&](std::ostream& o, std::size_t v) {
    const auto& node = drawing.nodes[v];
    o << "[label=\"" << node.name << "\\n" << node.type << "\", shape=" << (node.body ? "box" : "ellipse") << "]";
  });
  return out.str();
}

}  // namespace lithe
