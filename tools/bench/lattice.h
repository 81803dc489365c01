#pragma once

#include "engine/model/system_graph.h"

/// Structures full of closed loops, of unit rods (1 kg, 1 m), drawn at rest.
namespace lithe::bench {

/// Two level rails a metre apart, of two rods a cell, tied by a rung after every cell; joints are hinges about y, the
/// rails' first ones on ground. Five rods, three freedoms and a closed plane loop a cell. A rung's foot is a hinge too,
/// of which three rows a loop are redundant; or a slot along y, of which none is: the same motion. (With one rod a cell
/// it would be a beam in bending, whose constraints are the worse conditioned the longer it is, as its fourth power.)
enum class RungFoot { hinge, slot };
void draw_ladder(SystemGraph& graph, int cells, RungFoot foot);

/// A level net of `cells` x `width` squares, ball joints where rods meet; the edge at x = 0 (width + 1 joints) is on
/// ground. No row is redundant: straight lines of rods end freely.
void draw_grid(SystemGraph& graph, int cells, int width);

}  // namespace lithe::bench
