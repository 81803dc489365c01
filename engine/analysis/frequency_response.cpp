#include <algorithm>
#include <cmath>

#include "engine/analysis/state_space.h"
#include "engine/base/error.h"
#include "engine/output/chart.h"

namespace lithe {

std::vector<double> FrequencyResponse::decibels() const {
  std::vector<double> all;
  for (const Complex h : value) all.push_back(20 * std::log10(std::abs(h)));
  return all;
}

std::vector<double> FrequencyResponse::phase() const {
  std::vector<double> all;
  for (const Complex h : value) {
    double angle = std::arg(h) * 180 / M_PI;
    if (!all.empty()) angle += 360 * std::round((all.back() - angle) / 360);
    all.push_back(angle);
  }
  return all;
}

FrequencyResponse frequency_response(const StateSpace& system, int input, int output, double from, double to,
                                     int count) {
  if (!(from > 0) || !(to > from) || !std::isfinite(to) || count < 2)
    throw SceneError("cannot respond at " + std::to_string(count) + " frequencies from " + std::to_string(from) +
                         " to " + std::to_string(to) + " Hz",
                     "frequency_response", "give 0 < from < to and two frequencies or more");
  FrequencyResponse out{
      system.outputs.at(static_cast<std::size_t>(output)) + " by " + system.inputs.at(static_cast<std::size_t>(input)),
      {},
      {}};
  for (int k = 0; k < count; ++k)
    out.frequency.push_back(k + 1 == count ? to : from * std::pow(to / from, static_cast<double>(k) / (count - 1)));
  // Peaks and notches are a few damping ratios wide.
  std::vector<Complex> sharp = system.poles();
  const std::vector<Complex> zeros = system.zeros(input, output);
  sharp.insert(sharp.end(), zeros.begin(), zeros.end());
  for (const Complex s : sharp) {
    const double f = s.imag() / (2 * M_PI), width = std::abs(s.real()) / (2 * M_PI);
    if (!(f > from && f < to) || !(width < 0.2 * f)) continue;
    for (const double at : {-8.0, -4.0, -2.0, -1.0, -0.5, -0.2, 0.0, 0.2, 0.5, 1.0, 2.0, 4.0, 8.0}) {
      const double there = f + at * std::max(width, 1e-6 * f);
      if (there > from && there < to) out.frequency.push_back(there);
    }
  }
  std::sort(out.frequency.begin(), out.frequency.end());
  out.frequency.erase(std::unique(out.frequency.begin(), out.frequency.end()), out.frequency.end());
  // A frequency exactly on an undamped pole has no response.
  std::vector<double> kept;
  for (const double f : out.frequency) {
    const Complex h = system.response({0, 2 * M_PI * f})(output, input);
    if (!std::isfinite(std::abs(h)) || h == 0.0) continue;
    kept.push_back(f);
    out.value.push_back(h);
  }
  out.frequency = std::move(kept);
  return out;
}

void write_bode(const std::vector<FrequencyResponse>& responses, const std::string& path) {
  Chart amplitude{
      .title = "Amplitude", .x_label = "Frequency [Hz]", .y_label = "Amplitude [dB]", .lines = {}, .log_x = true};
  Chart phase{.title = "Phase", .x_label = "Frequency [Hz]", .y_label = "Phase [degrees]", .lines = {}, .log_x = true};
  for (const FrequencyResponse& r : responses) {
    amplitude.lines.push_back({r.title, r.frequency, r.decibels()});
    phase.lines.push_back({r.title, r.frequency, r.phase()});
  }
  write_chart(amplitude, path + "_amplitude");
  write_chart(phase, path + "_phase");
}

void write_nyquist(const std::vector<FrequencyResponse>& responses, const std::string& path) {
  Chart chart{.title = "Nyquist", .x_label = "Real part", .y_label = "Imaginary part", .lines = {}};
  for (const FrequencyResponse& r : responses) {
    ChartLine line{r.title, {}, {}};
    for (const Complex h : r.value) line.x.push_back(h.real()), line.y.push_back(h.imag());
    chart.lines.push_back(std::move(line));
  }
  write_chart(chart, path);
}

}  // namespace lithe
