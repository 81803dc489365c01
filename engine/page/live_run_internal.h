#pragma once

#include <chrono>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "engine/model/input.h"
#include "engine/page/loopback_server_internal.h"
#include "engine/page/run_record_internal.h"

namespace lithe {

/// A run in the browsers that follow it: the states that show() is given, and what their pages ask for. The server's
/// thread reads copies of states and leaves wishes, under one lock; the scene is the run's thread's alone.
///
/// GET  /                         the page, with the first state
/// GET  /frames?from=N&thinned=K  messages, as long as the run goes on: kind and bytes (uint32), then the bytes, a
///                                multiple of 8, all little-endian. tools/viewer/README.md has the kinds
/// POST /command                  {"do": "run" | "pause" | "step" | "stop"}, {"speed": s}, {"input": name, "value": x}
class LiveRun {
 public:
  LiveRun(std::string name, const FollowOptions& options, std::vector<Input*> inputs, const std::string& where);
  /// Browsers that read get what they lack, for two seconds at most.
  ~LiveRun();

  const std::string& url() const { return server_.url(); }

  /// Called with each state by the run's thread; `record` has the description. Waits while the page holds the run, sets
  /// inputs, and throws StopRun where the page ends it.
  void show(const RunRecord& record, const VectorX& row, const std::vector<double>& contacts);

 private:
  using Clock = std::chrono::steady_clock;
  using Lock = std::unique_lock<std::mutex>;
  struct Frame {
    VectorX row;
    std::vector<double> contacts;
  };
  /// How far a browser is.
  struct Reader {
    std::size_t next = 1;  // the page has the first frame
    long thinned = 0, status = -1;
  };
  struct Slider {
    Input* input;
    double value = 0;
    double ends = 0;  // its last ramp, s
  };

  // The run's thread.
  void keep(const VectorX& row, const std::vector<double>& contacts);
  void hold(Lock& lock, double time, bool is_first);
  void set_inputs(double time);
  void set(Slider& slider, double time, double value) const;
  void set_pace(double time);
  // The server's.
  HttpResponse answer(const HttpRequest& request);
  HttpResponse page();
  HttpResponse follow(const HttpRequest& request);
  HttpResponse obey(const std::string& text);
  bool write_news(Reader& reader, std::string& bytes);
  std::string status() const;
  // With the lock held: readers are to see it.
  void tell() { ++changes_, server_.wake(), news_.notify_all(); }

  const std::string name_;
  const FollowOptions options_;

  std::mutex mutex_;
  std::condition_variable news_;
  std::shared_ptr<const RunRecord> first_;            // description and first state
  std::vector<std::shared_ptr<const Frame>> frames_;  // every every_-th state
  std::size_t bytes_ = 0;                             // of them
  long every_ = 1, thinned_ = 0, observed_ = 0;
  long changes_ = 0;  // of what status() tells
  std::string state_ = "running", problem_;
  double speed_;
  long steps_left_ = 0;
  bool stopping_ = false, ended_ = false;
  std::vector<Slider> sliders_;
  std::map<std::string, double> wishes_;                // values of inputs, to be set
  Clock::time_point pace_since_, seen_ = Clock::now();  // wall clock at pace_from_; when somebody read last
  double pace_from_ = 0;                                // s

  std::string page_;       // the server's thread's alone, once made
  LoopbackServer server_;  // last: its thread uses the others
};

}  // namespace lithe
