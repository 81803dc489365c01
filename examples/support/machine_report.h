#pragma once

#include <functional>
#include <string>
#include <vector>

#include "lithe/lithe.h"

/// What all machines of the gallery do with their scenes, and say and check at their ends.
namespace machine {

/// A scene that is drawn, and how it is run.
struct Machine {
  std::string name;                                    // of its page: results/machines/NAME.html
  std::string title;                                   // on the page
  double duration = 0;                                 // s
  double interval = 0.02;                              // s between samples, and between the page's pictures
  lithe::Tolerance tolerance{1e-5, 1e-7};              // of Automatic, and of the second method
  std::vector<lithe::Sensor> sensors{};                // recorded, charts of the page, compared between both methods
  double agreement = 1e-3;                             // of both methods, in parts of the largest change of each sensor
  double balance = 1e-3;                               // of the energy account, in parts of what was turned over
  lithe::MakeIntegratorBy<lithe::Tolerance> second{};  // none: Radau
  double compared = 0;                                 // s of the run that the second method repeats; 0: all
  std::function<lithe::State(const lithe::System&)> start{};  // none: as drawn, from rest
  std::function<void(lithe::Simulation&)> prepare{};  // before each run, inputs as drawn: events, samples of inputs
  std::function<void(lithe::Run&)> draw{};            // shapes of bodies on the page
  /// W on the bodies, of what is neither a force element nor a CoordinateDrive: contacts.
  std::vector<lithe::Sensor> powers{};
  /// For solve(), of a machine with bodies from whose models it can choose; and for how long, s.
  std::vector<lithe::Want> wants{};
  double solve_duration = 0;
};

struct Outcome {
  lithe::Table table;  // of Automatic: "t" and the sensors' columns, a row an interval
  bool good;           // energy, agreement, page, and solve() if asked, are as they should be
};

/// Runs the machine with Automatic and writes its page; keeps an account of its energy; runs it again by the second
/// method; asks solve() for its wants, last, since that changes the bodies' models. Prints what came out, and the row
/// for the table of examples/machines/README.md.
///   account: E(t) - E(0) = ∫ (power of forces and drives - power lost in damped bodies) dt,   E of the bodies
Outcome run(lithe::SystemGraph& graph, const Machine& machine);

/// The first value of a column at or after a time of the run (s), for checks.
double at(const lithe::Table& table, const std::string& column, double time);

/// |L| of all rigid and flexible bodies about the origin of the world, N m s.
lithe::Sensor angular_momentum(const lithe::SystemGraph& graph);

}  // namespace machine
