#include "engine/run/followed_inputs.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "engine/archive/archive.h"
#include "engine/base/error.h"
#include "engine/model/event_memory.h"
#include "engine/model/islands.h"

namespace lithe {

FollowedInputs::FollowedInputs(const System& system) {
  if (!system.graph().inputs().empty() && depends_on_time(system.graph())) inputs_ = system.graph().inputs();
  seen_.resize(2 * inputs_.size());
}

double FollowedInputs::next_stop(double time, double stop) const {
  for (const Input* input : inputs_) stop = std::min(stop, input->next_kink(time));
  return stop;
}

void FollowedInputs::end_at(double time) const {
  for (const Input* input : inputs_) input->end_at(time);
}

void FollowedInputs::release() const { end_at(std::numeric_limits<double>::infinity()); }

void FollowedInputs::see(double time) {
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    const Motion now = inputs_[i]->at(time);
    seen_[2 * i] = now.value, seen_[2 * i + 1] = now.rate;
  }
}

bool FollowedInputs::changed(double time) {
  release();
  bool other = false;
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    const Motion now = inputs_[i]->at(time);
    other |= now.value != seen_[2 * i] || now.rate != seen_[2 * i + 1];
  }
  if (other) see(time);
  return other;
}

void FollowedInputs::history(Archive& archive) {
  archive.same("count", static_cast<double>(inputs_.size()));
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    Input& input = *inputs_[i];
    archive.group(input.name(), [&] {
      std::vector<double> times, values;
      for (const Input::Sample& s : input.samples()) times.push_back(s.time), values.push_back(s.value);
      archive("times", times);
      archive("values", values);
      archive("seen value", seen_[2 * i]);
      archive("seen rate", seen_[2 * i + 1]);
      if (!archive.loads()) return;
      if (times.empty() || times.size() != values.size() ||
          std::adjacent_find(times.begin(), times.end(), std::greater_equal<>()) != times.end())
        throw FileError("the checkpoint's samples of input '" + input.name() + "' are not whole", archive.source(),
                        "resume from an older one, or start a new run");
      input.reset(times.front(), values.front());
      for (std::size_t k = 1; k < times.size(); ++k) input.set(times[k], values[k]);
    });
  }
}

namespace {

void set_memories_as_drawn(const SystemGraph& graph, bool drawn) {
  for (const auto& entry : graph.forces())
    if (const auto* memory = dynamic_cast<const EventMemory*>(entry.force)) memory->set_as_drawn(drawn);
}

}  // namespace

InputsAsDrawn::InputsAsDrawn(const SystemGraph& graph) : graph_(graph) {
  for (const Input* input : graph_.inputs()) input->force({input->parameters().value, 0, 0});
  set_memories_as_drawn(graph_, true);
}

InputsAsDrawn::~InputsAsDrawn() {
  for (const Input* input : graph_.inputs()) input->release();
  set_memories_as_drawn(graph_, false);
}

}  // namespace lithe
