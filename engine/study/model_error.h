#pragma once

#include <vector>

#include "engine/study/driven_oscillators.h"
#include "engine/study/model_run.h"

namespace lithe {

/// What a richer model would have made of a run: of its elastic coordinates, and of the wanted quantities.
struct ModelError {
  struct Coordinate {
    int body;                    // of BodyModels::bodies()
    int mode;                    // of the body's candidates
    double frequency;            // Hz, of the candidate
    double amplitude;            // largest |δη|
    std::vector<double> effect;  // of this coordinate alone on each sensor: largest norm of its columns' change
  };
  std::vector<Coordinate> coordinates;
  DrivenOscillators::Response response;
  std::vector<State> states;                         // of the richer model, a sample each
  Table samples;                                     // of the sensors, as the richer model would have them
  std::vector<double> effect;                        // of all coordinates together, on each sensor
  std::vector<RecordedWrench::Parameters> feedback;  // what deformation does to the motion at large
};

/// What is looked at: all coordinates together, where the effect of a single one is its part by strain energy; or each
/// by itself, where it is largest, and no more.
enum class Detail { whole, each };

/// The equations of a model with more modes along a run of a poorer one: what they leave over, M v̇ + Gᵀλ - f, drives
/// each mode that the run lacks as an oscillator (DrivenOscillators), whose response is evaluated exactly and includes
/// the quasi-static part; bodies recoil in the metric of their masses so that joints hold. What the deformation then
/// does to the motion at large is `feedback`. All samples drive the oscillators; what they do is looked at in every
/// `stride`th. The graph is left at the richer fidelity; a run with its dynamics is needed.
ModelError model_error(SystemGraph& graph, BodyModels& bodies, const ModelRun& run, const std::vector<Fidelity>& richer,
                       const std::vector<Sensor>& sensors, int stride = 1, Detail detail = Detail::whole);

/// Largest difference of two tables at the times that both have, a sensor each: the Euclidean norm over its columns.
std::vector<double> sample_differences(const std::vector<Sensor>& sensors, const Table& a, const Table& b);
/// Largest change from the first sample, likewise.
std::vector<double> sample_changes(const std::vector<Sensor>& sensors, const Table& samples);

}  // namespace lithe
