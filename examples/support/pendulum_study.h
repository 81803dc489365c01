#pragma once

#include <array>
#include <string>
#include <vector>

#include "lithe/lithe.h"

/// Runs variants of the flexible pendulum and tells how far each is from the nonlinear finite-element reference.
namespace pendulum {

/// One sample a millisecond: time, tip position and velocity, world axes, SI.
struct Sample {
  double t;
  lithe::Vector3 position, velocity;
};
using Trajectory = std::vector<Sample>;

/// How the body hangs on its hinge edge.
enum class Hinge {
  revolute,  // five rows at the mean of the hinge nodes
  nodes,     // every hinge node held: three-node fixation, as the paper has it
};

struct Variant {
  std::string name;  // "hex8i_9_modes"
  std::string body;  // folder of examples/data/pendulum
  lithe::BodyFrame frame;
  int modes;  // number of modes, 0: rigid, lithe::kAllNodal
  Hinge hinge = Hinge::revolute;
  double step = 5e-5;  // s
  lithe::Deflection deflection = lithe::Deflection::linear;
};

struct Outcome {
  Variant variant;
  Trajectory trajectory;
  int coordinates = 0;  // elastic coordinates
  lithe::IntegratorStatistics statistics;
  double cpu = 0;                        // s
  double max_dev_z = 0, max_dev_vz = 0;  // m, m/s, over the second
  double within_bounds = 1;              // s, first time at which 4e-4 m or 4e-2 m/s is passed
  double energy_drift = 0;               // relative to the largest kinetic energy
  double residual = 0;                   // largest |g|
  lithe::VectorX frequencies;            // Hz
};

/// Reads the body's matrices as CalculiX wrote them.
lithe::FiniteElementModel read_rod(const std::string& body);
Trajectory read_reference(const std::string& body);

/// One second of swinging, compared with the reference of the same mesh.
Outcome run(const Variant& variant, const lithe::FiniteElementModel& model, const Trajectory& reference);
/// The same scene at a time step so small that its own error can be neglected: what the model alone gives.
Trajectory run_exactly(const Variant& variant, const lithe::FiniteElementModel& model);

/// The deformed body in fifty frames of the second, for ParaView: PATH.pvd.
void write_deformed_body(const Variant& variant, const lithe::FiniteElementModel& model, const std::string& path);

/// Largest |Δz| (m) and |Δvz| (m/s).
std::array<double, 2> deviation(const Trajectory& a, const Trajectory& b);

void write_trajectory(const Trajectory& trajectory, const std::string& path);
void write_summary(const std::vector<Outcome>& outcomes, const std::string& path);
/// z.svg/.png and vz.svg/.png: the paper's figures 3 and 4.
void write_charts(const std::vector<Outcome>& outcomes, const Trajectory& reference, const std::string& folder);
/// deviation.svg/.png: |Δz| of the tip over time, logarithmic.
void write_deviation_chart(const std::vector<Outcome>& outcomes, const Trajectory& reference,
                           const std::string& folder);
/// The pictures' numbers in words: a table of the variants, and where their errors come from.
struct ErrorBudget {
  std::array<double, 2> model, reduction, time, frame;  // m, m/s
  std::array<double, 2> fixation_model_frame, revolute_model_frame;
};
void write_report(const std::vector<Outcome>& outcomes, const ErrorBudget& budget, const std::string& path);

}  // namespace pendulum
