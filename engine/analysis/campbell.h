#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/analysis/linearization.h"
#include "engine/output/table.h"

namespace lithe {

struct CampbellOptions {
  int mode_count = 8;                // modes followed: those of lowest frequency at the first speed
  double lowest_frequency = 1e-3;    // Hz; slower modes are free motions, not vibrations
  std::vector<double> orders = {1};  // lines f = order · speed, excitation that rotates with the rotor
};

/// Frequencies and damping of a rotating mechanism over its speed: one branch per mode, followed from
/// speed to speed by the similarity of shapes (modal assurance criterion |a·b|²/(a·a b·b)) and by the trend of its
/// frequency. Branches may cross. In world axes (PerturbationAxes) frequencies are those of the whirl in the inertial
/// frame; in body axes those in the rotating frame: lower by the speed for forward whirl, higher for backward.
struct Campbell {
  struct Branch {
    std::vector<double> speed;          // rad/s; ends where the mode no longer oscillates
    std::vector<double> frequency;      // Hz
    std::vector<double> damping_ratio;  // below zero: unstable
  };
  std::vector<Branch> branches;  // by frequency at the first speed
  std::vector<double> orders;

  /// Columns speed (rad/s), mode, frequency (Hz), damping_ratio; one row a mode and speed.
  Table table() const;
  void write_csv(const std::string& path) const;
  /// The diagram as path.svg and path.png (engine/output/chart.h).
  void write_chart(const std::string& path_without_extension, const std::string& title) const;
};

/// `scene` draws, assembles and linearizes at a speed in rad/s; `speeds` ascend. Small steps in speed make the tracking
/// of branches reliable. Throws SceneError without speeds, or if nothing oscillates at the first.
Campbell campbell(const std::vector<double>& speeds, const std::function<Linearization(double speed)>& scene,
                  const CampbellOptions& options = {});

}  // namespace lithe
