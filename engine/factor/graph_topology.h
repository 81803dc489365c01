#pragma once

#include <string>
#include <vector>

namespace lithe {

/// A graph of bodies and the constraints that tie them; the one home of Boost.Graph.
/// Bodies are 0 .. body_count-1, -1 is ground.
struct Topology {
  int body_count = 0;
  std::vector<std::vector<int>> ties;  // bodies of each constraint, ground as -1, no body twice
};

/// Island number of each body: bodies that no chain of constraints connects (ground does not connect) differ.
std::vector<int> islands(const Topology& topology);

/// Whether any constraints close a loop (through ground counts too): only then can rows depend on each other's.
bool has_loops(const Topology& topology);

/// The body in the middle of each large tree: without it no part has more than half of the tree's bodies. Eliminated
/// last, it leaves branches that do not know each other. None of small trees, nor of what closes loops. `dimensions`:
/// of the bodies, then the constraints.
std::vector<int> centres(const Topology& topology, const std::vector<int>& dimensions);

/// Gaussian elimination as symbols.
struct Elimination {
  std::vector<int> order;                    // of the vertices
  std::vector<std::vector<int>> neighbours;  // of each vertex when its turn comes, sorted: between them it fills in
};

/// The tree of an elimination: of each vertex the first of its neighbours that goes after it, -1 of the last ones.
std::vector<int> parents(const Elimination& elimination);

/// An order in which Gaussian elimination of [S Gᵀ; G 0] fills in little and never meets a zero block.
/// Vertices: bodies, then constraints (body_count + c). Trees fill in nothing. `couplings`: pairs of bodies with a
/// block of their own. A constraint is eliminated after all its bodies, or, where it alone holds a part of the graph
/// that does not touch ground, after that part: in both cases its pivot block is minus a compliance, definite if its
/// rows are independent. Among the eligible, the one with the smallest remaining neighbourhood goes first.
/// `first`: the neighbours of further vertices, numbered after the constraints, that go before all others. `last`:
/// bodies that wait until nothing else can go. The order is such that what depends on each other follows each other: a
/// factorisation passes over memory once.
Elimination plan_elimination(const Topology& topology, const std::vector<int>& dimensions,
                             const std::vector<std::pair<int, int>>& couplings,
                             const std::vector<std::vector<int>>& first = {}, const std::vector<int>& last = {});

/// Graphviz text: bodies are boxes, connectors ellipses, edges carry marker names.
struct GraphDrawing {
  struct Node {
    std::string name, type;
    bool body;
  };
  struct Edge {
    int from, to;
  };
  std::vector<Node> nodes;
  std::vector<Edge> edges;
};
std::string graphviz(const GraphDrawing& drawing);

}  // namespace lithe
