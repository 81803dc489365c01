#include "engine/page/live_run_internal.h"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>

#include "engine/base/interrupt.h"
#include "engine/observe/stop_run.h"

namespace lithe {
namespace {

using Json = nlohmann::json;
using Seconds = std::chrono::duration<double>;

constexpr auto kGlance = std::chrono::milliseconds(50);  // between looks at signals and who is there
constexpr auto kAbsence = std::chrono::seconds(5);       // of all browsers, after which nothing is held
constexpr auto kFarewell = std::chrono::seconds(2);
constexpr std::size_t kPiece = 1 << 20;  // bytes that are sent at once
constexpr double kBehind = 0.1;          // s that a run catches up with the clock

enum class Kind : std::uint32_t { frame = 1, thinned = 2, status = 3 };

void append(std::string& bytes, Kind kind, std::size_t size) {
  const std::uint32_t head[2] = {static_cast<std::uint32_t>(kind), static_cast<std::uint32_t>(size)};
  bytes.append(reinterpret_cast<const char*>(head), sizeof head);
}
void append(std::string& bytes, const double* values, std::size_t count) {
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof *values);
}

/// The number behind "name=" in a query; `otherwise` where there is none.
long number_in(const std::string& query, const std::string& name, long otherwise) {
  const std::size_t at = ("&" + query).find("&" + name + "=");
  if (at == std::string::npos) return otherwise;
  long number = otherwise;
  std::from_chars(query.data() + at + name.size() + 1, query.data() + query.size(), number);
  return number;
}

Json finite(double value) { return std::isfinite(value) ? Json(value) : Json(); }

}  // namespace

LiveRun::LiveRun(std::string name, const FollowOptions& options, std::vector<Input*> inputs, const std::string& where)
    : name_(std::move(name)),
      options_(options),
      speed_(options.speed),
      server_(
          options.port, [this](const HttpRequest& request) { return answer(request); }, where) {
  const std::lock_guard lock(mutex_);
  for (Input* input : inputs) sliders_.push_back({input, input->parameters().value, 0});
  std::fprintf(stderr, "run '%s' %s at %s\n", name_.c_str(),
               options.wait > 0 ? "waits for a browser" : "can be followed", url().c_str());
}

LiveRun::~LiveRun() {
  Lock lock(mutex_);
  ended_ = true;
  state_ = "ended";
  tell();
  const auto until = Clock::now() + kFarewell;
  while (server_.stream_count() > 0 && Clock::now() < until) news_.wait_for(lock, kGlance);
}

void LiveRun::show(const RunRecord& record, const VectorX& row, const std::vector<double>& contacts) {
  Lock lock(mutex_);
  const bool is_first = !first_;
  if (is_first) {
    RunRecord first{.name = record.name, .scene = record.scene, .sets = record.sets, .width = record.width};
    first.rows.assign(row.begin(), row.end());
    first.contacts = contacts;
    first_ = std::make_shared<const RunRecord>(std::move(first));
    set_pace(row[0]);
  }
  keep(row, contacts);
  if (server_.stream_count() > 0) server_.wake();
  hold(lock, row[0], is_first);
  if (stopping_) throw StopRun{"the page of run '" + name_ + "'"};
}

/// Of a long run every second, fourth … state: those that a page would have to hold.
void LiveRun::keep(const VectorX& row, const std::vector<double>& contacts) {
  if (observed_++ % every_ != 0) return;
  frames_.push_back(std::make_shared<const Frame>(row, contacts));
  const auto size = [](const Frame& frame) { return (frame.row.size() + frame.contacts.size()) * sizeof(double); };
  bytes_ += size(*frames_.back());
  if (bytes_ <= options_.kept || frames_.size() < 3) return;
  for (std::size_t i = 0; 2 * i < frames_.size(); ++i) frames_[i] = frames_[2 * i];
  frames_.resize((frames_.size() + 1) / 2);
  bytes_ = 0;
  for (const auto& frame : frames_) bytes_ += size(*frame);
  every_ *= 2, ++thinned_;
}

/// Until the page lets the run go on. Where nobody looks, nothing is held.
void LiveRun::hold(Lock& lock, double time, bool is_first) {
  const auto begun = Clock::now();
  const auto is_absent = [&](Seconds how_long) {
    const auto now = Clock::now();
    if (server_.stream_count() == 0) return now - seen_ >= how_long;
    seen_ = now;
    return false;
  };
  for (bool first_look = true;; first_look = false) {
    set_inputs(time);
    if (stopping_ || InterruptGuard::asked() != 0) return;
    const auto now = Clock::now();
    if (is_first && is_absent(Seconds(0)) && now - begun < Seconds(options_.wait)) {
      news_.wait_for(lock, kGlance);
      set_pace(time);
      continue;
    }
    if (state_ == "paused") {
      if (is_absent(kAbsence)) {
        state_ = "running";
        return set_pace(time);
      }
      if (steps_left_ > 0) {
        steps_left_ -= 1;
        return;
      }
      news_.wait_for(lock, kGlance);
      set_pace(time);
      continue;
    }
    if (speed_ <= 0 || is_absent(Seconds(0))) return;
    const auto due = pace_since_ + std::chrono::duration_cast<Clock::duration>(Seconds((time - pace_from_) / speed_));
    if (now >= due) {
      if (first_look && now - due > Seconds(kBehind)) set_pace(time);
      return;
    }
    news_.wait_until(lock, std::min(due, now + kGlance));
  }
}

void LiveRun::set_pace(double time) { pace_since_ = Clock::now(), pace_from_ = time; }

void LiveRun::set_inputs(double time) {
  bool moved = false;
  for (Slider& slider : sliders_) {
    if (const auto wish = wishes_.find(slider.input->name()); wish != wishes_.end() && slider.ends <= time) {
      try {
        set(slider, time, wish->second);
        problem_.clear();
      } catch (const Error& error) {
        problem_ = error.problem() + "; " + error.fix();
      }
      wishes_.erase(wish);
      moved = true;
    }
    // What begins here: at a jump value() tells what ends.
    const Input::Sample& last = slider.input->samples().back();
    const double value = last.time <= time ? last.value : slider.input->value(time);
    moved |= value != slider.value;
    slider.value = value;
  }
  if (moved) tell();
}

void LiveRun::set(Slider& slider, double time, double value) const {
  Input& input = *slider.input;
  input.require(time, value, "the page of run '" + name_ + "'");
  if (input.between() == Input::Between::held) return input.set(time, value);
  const Input::Sample last = input.samples().back();
  input.set(time, last.value);  // it has stood there since: the way begins here
  input.set(time + options_.ramp, value);
  slider.ends = time + options_.ramp;
}

HttpResponse LiveRun::answer(const HttpRequest& request) {
  try {
    if (request.method == "POST" && request.path == "/command") return obey(request.body);
    if (request.method == "GET" && request.path == "/frames") return follow(request);
    if (request.method == "GET" && request.path == "/") return page();
    return {.status = 404, .body = "there are /, /frames and /command\n"};
  } catch (const std::exception& error) {
    return {.status = 500, .body = std::string(error.what()) + "\n"};
  }
}

HttpResponse LiveRun::page() {
  std::shared_ptr<const RunRecord> first;
  {
    const std::lock_guard lock(mutex_);
    first = first_;
  }
  if (!first) return {.status = 503, .body = "the run has no state yet: reload this page\n"};
  if (page_.empty()) page_ = page_text({first.get()}, {.title = name_}, url(), PageKind::live);
  return {.type = "text/html; charset=utf-8", .body = page_};
}

HttpResponse LiveRun::follow(const HttpRequest& request) {
  const std::lock_guard lock(mutex_);
  Reader reader{.next = static_cast<std::size_t>(std::max(1L, number_in(request.query, "from", 1))),
                .thinned = number_in(request.query, "thinned", thinned_)};
  if (reader.thinned < 0 || reader.thinned > thinned_)
    return {.status = 400, .body = "frames were thinned " + std::to_string(thinned_) + " times\n"};
  return {.type = "application/octet-stream",
          .more = [this, reader](std::string& bytes) mutable { return write_news(reader, bytes); }};
}

bool LiveRun::write_news(Reader& reader, std::string& bytes) {
  const std::lock_guard lock(mutex_);
  for (; reader.thinned < thinned_; ++reader.thinned, reader.next = (reader.next + 1) / 2)
    append(bytes, Kind::thinned, 0);
  for (; reader.next < frames_.size() && bytes.size() < kPiece; ++reader.next) {
    const Frame& frame = *frames_[reader.next];
    const auto width = static_cast<std::size_t>(frame.row.size());
    append(bytes, Kind::frame, (width + frame.contacts.size()) * sizeof(double));
    append(bytes, frame.row.data(), width);
    append(bytes, frame.contacts.data(), frame.contacts.size());
  }
  if (reader.status != changes_) {
    std::string text = status();
    text.resize((text.size() + 7) / 8 * 8, ' ');
    append(bytes, Kind::status, text.size());
    bytes += text;
    reader.status = changes_;
  }
  return !ended_ || reader.next < frames_.size();
}

std::string LiveRun::status() const {
  Json inputs = Json::array();
  for (const Slider& slider : sliders_) {
    const Input::Parameters& p = slider.input->parameters();
    inputs.push_back({{"name", slider.input->name()},
                      {"unit", p.unit},
                      {"description", p.description},
                      {"lower", finite(p.lower)},
                      {"upper", finite(p.upper)},
                      {"value", finite(slider.value)}});
  }
  return Json{{"state", state_}, {"speed", speed_}, {"problem", problem_}, {"thinned", thinned_}, {"inputs", inputs}}
      .dump(-1, ' ', false, Json::error_handler_t::replace);
}

HttpResponse LiveRun::obey(const std::string& text) {
  const Json wish = Json::parse(text, nullptr, false);
  const auto refuse = [](const std::string& why) { return HttpResponse{.status = 400, .body = why + "\n"}; };
  if (!wish.is_object()) return refuse("a command is an object of JSON");
  const auto number = [&](const char* name) { return wish.contains(name) && wish[name].is_number(); };
  const std::lock_guard lock(mutex_);
  if (number("speed") && wish["speed"].get<double>() >= 0) {
    speed_ = wish["speed"].get<double>();
    if (!frames_.empty()) set_pace(frames_.back()->row[0]);
  } else if (wish.contains("input") && wish["input"].is_string() && number("value")) {
    const auto name = wish["input"].get<std::string>();
    if (std::none_of(sliders_.begin(), sliders_.end(), [&](const Slider& s) { return s.input->name() == name; }))
      return refuse("the scene has no input '" + name + "'");
    wishes_[name] = wish["value"].get<double>();
  } else if (const std::string what =
                 wish.contains("do") && wish["do"].is_string() ? wish["do"].get<std::string>() : "";
             what == "pause" || what == "run") {
    state_ = what == "run" ? "running" : "paused";
    steps_left_ = 0;
  } else if (what == "step") {
    state_ = "paused";
    steps_left_ += 1;
  } else if (what == "stop") {
    stopping_ = true;
    state_ = "stopping";
  } else {
    return refuse(
        "the commands are {\"do\": \"run\" | \"pause\" | \"step\" | \"stop\"}, {\"speed\": s}, "
        "{\"input\": name, \"value\": x}");
  }
  tell();
  return {.status = 204};
}

}  // namespace lithe
