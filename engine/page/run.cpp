#include "engine/page/run.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "engine/base/number_text.h"
#include "engine/page/live_run_internal.h"
#include "engine/page/run_record_internal.h"

namespace lithe {

struct Run::Parts {
  RunOptions options;
  const System* system = nullptr;
  std::vector<Sensor> sensors;
  std::vector<SceneRecorder::Drawn> drawn;
  std::vector<PlacedField> fields;  // not in the record yet: a stream is read back first
  std::string path;                 // of a stream
  std::shared_ptr<RunRecord> record = std::make_shared<RunRecord>();
  std::unique_ptr<SceneRecorder> recorder;  // since the first state
  std::unique_ptr<RunFile> file;
  std::unique_ptr<LiveRun> live;
  int frames = 0;
  double last_time = 0;
  VectorX row;
  std::vector<double> contacts;

  void require_fresh(const std::string& call) const {
    if (recorder || !system)
      throw SceneError("the run '" + options.name + "' has begun", "Run::" + call, "call it before simulation.run()");
  }
};

Run::Run(const System& system, std::vector<Sensor> sensors, RunOptions options, std::source_location where)
    : parts_(new Parts{.options = std::move(options), .system = &system, .sensors = std::move(sensors)}) {
  std::vector<std::string> names;
  for (const Sensor& sensor : parts_->sensors)
    names.insert(names.end(), sensor.columns().begin(), sensor.columns().end());
  std::sort(names.begin(), names.end());
  if (const auto twice = std::adjacent_find(names.begin(), names.end()); twice != names.end())
    throw SceneError("two columns of the run '" + parts_->options.name + "' are called '" + *twice + "'",
                     to_string(where), "name one of the sensors, as in height(marker, \"tip\")");
  if (const char* port = std::getenv(kFollowVariable)) follow_as_asked(port);
}
Run::Run(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Run::Run(Run&& other) noexcept : Observer(), parts_(std::move(other.parts_)) {}
Run& Run::operator=(Run&& other) noexcept {
  parts_ = std::move(other.parts_);
  return *this;
}
Run::~Run() = default;

void Run::draw(const Body& body, DrawnShape shape) {
  parts_->require_fresh("draw");
  parts_->drawn.push_back({&body, std::move(shape)});
}

void Run::stream(const std::string& path) {
  parts_->require_fresh("stream");
  parts_->path = path;
}

std::string Run::follow(const FollowOptions& options, std::source_location where) {
  parts_->require_fresh("follow");
  if (parts_->live) return parts_->live->url();
  const auto is_duration = [](double value) { return value >= 0; };
  if (!is_duration(options.speed) || !std::isfinite(options.speed) || !is_duration(options.wait) ||
      !(options.ramp > 0) || !std::isfinite(options.ramp))
    throw SceneError("the run '" + parts_->options.name + "' is to be followed with a speed of " +
                         number_text(options.speed) + ", a wait of " + number_text(options.wait) + " s and ramps of " +
                         number_text(options.ramp) + " s",
                     to_string(where), "give a speed and a wait of at least 0, and longer ramps than 0");
  parts_->live =
      std::make_unique<LiveRun>(parts_->options.name, options, parts_->system->graph().inputs(), to_string(where));
  return parts_->live->url();
}

void Run::follow_as_asked(const std::string& text) {
  FollowOptions options{.speed = 1, .wait = std::numeric_limits<double>::infinity()};
  const auto read = std::from_chars(text.data(), text.data() + text.size(), options.port);
  if (read.ec != std::errc() || *read.ptr != 0)
    throw SceneError("'" + text + "' is no port", kFollowVariable, "give a number, 0 for any port that is free");
  follow(options);
}

void Run::observe(Snapshot& now) {
  Parts& p = *parts_;
  if (!p.recorder) {
    if (&now.system() != p.system)
      throw SceneError("the run '" + p.options.name + "' receives the state of another system", "Run::observe",
                       "make it of the system that is simulated");
    p.recorder = std::make_unique<SceneRecorder>(now, p.sensors, p.options, p.drawn, *p.record);
    if (!p.path.empty()) p.file = std::make_unique<RunFile>(p.path, *p.record);
  }
  if (p.frames > 0 && now.time() == p.last_time) return;  // told twice of one instant: at an event
  if (p.frames > 0 && now.time() < p.last_time)
    throw SceneError("the run '" + p.options.name + "' has seen " + time_text(p.last_time) + " and is shown " +
                         time_text(now.time()),
                     "Run::observe", "record each simulation into a run of its own");
  if (!p.path.empty() && !p.file)
    throw SceneError("the file of the run '" + p.options.name + "' is closed: its page was written", p.path,
                     "write the page when the simulation is over");
  p.recorder->fill(now, p.frames, p.row, p.contacts);
  if (p.file) {
    p.file->append(p.row, p.contacts);
  } else {
    p.record->rows.insert(p.record->rows.end(), p.row.begin(), p.row.end());
    p.record->contacts.insert(p.record->contacts.end(), p.contacts.begin(), p.contacts.end());
  }
  p.last_time = now.time();
  ++p.frames;
  if (p.live) p.live->show(*p.record, p.row, p.contacts);
}

void Run::add(const std::vector<EventRecord>& events) {
  if (parts_->file)
    parts_->file->append(events);
  else
    parts_->record->events.insert(parts_->record->events.end(), events.begin(), events.end());
}

void Run::add(const Body& body, const MeshField& field) {
  Parts& p = *parts_;
  const std::string where = "the field '" + field.name + "' of the run '" + p.options.name + "'";
  if (!p.recorder)
    throw SceneError("the run has observed no state", where, "add fields to the run that was recorded, after it");
  const auto [number, mesh] = p.recorder->mesh_of(body);
  const int last = mesh.nodes.empty() ? -1 : *std::max_element(mesh.nodes.begin(), mesh.nodes.end());
  if (field.values.size() <= last || !field.values.allFinite())
    throw SceneError(std::to_string(field.values.size()) + " values for the nodes of '" + body.name() +
                         "', of which the last that is drawn has number " + std::to_string(last) +
                         ", or one that is not finite",
                     where, "give one finite value a node, by index");
  p.fields.push_back({number, field.name, field.unit, field.values(mesh.nodes).transpose()});
}

int Run::frame_count() const { return parts_->frames; }
const std::string& Run::name() const { return parts_->options.name; }

std::shared_ptr<const RunRecord> Run::record() const {
  if (parts_->file) {
    parts_->file.reset();
    *parts_->record = read_run_file(parts_->path);
  }
  for (const PlacedField& field : parts_->fields) add_field(*parts_->record, field);
  parts_->fields.clear();
  return parts_->record;
}

std::vector<double> Run::channel(const Located& name) const { return channel_of(*record(), name); }

Run Run::read(const std::string& path, const std::string& name) {
  auto parts = std::make_unique<Parts>();
  *parts->record = read_run_file(path);
  if (!name.empty()) parts->record->name = name;
  parts->frames = parts->record->row_count();
  parts->options.name = parts->record->name;
  return Run(std::move(parts));
}

}  // namespace lithe
