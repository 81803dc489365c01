#include "tools/differential/campaign.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <map>
#include <stdexcept>

#include "engine/base/interrupt.h"
#include "engine/base/log.h"
#include "tools/differential/judgement.h"

namespace lithe::differential {
namespace {

constexpr rlim_t kMemory = rlim_t{4} << 30;  // bytes

struct Child {
  std::uint32_t seed;
  pid_t pid;
  int pipe;
};

/// What it writes: lines "begins ...", then a verdict and its text.
[[noreturn]] void work(std::uint32_t seed, const std::vector<int>& left_out, double seconds, int out) {
  const auto cpu = static_cast<rlim_t>(std::ceil(seconds));
  const rlimit time{cpu, cpu + 5}, memory{kMemory, kMemory}, core{0, 0};
  setrlimit(RLIMIT_CPU, &time), setrlimit(RLIMIT_AS, &memory), setrlimit(RLIMIT_CORE, &core);
  std::signal(SIGINT, SIG_DFL), std::signal(SIGTERM, SIG_DFL);  // the campaign's guard is not its own
  const auto say = [out](const std::string& text) {
    if (write(out, text.data(), text.size()) < 0) _exit(2);
  };
  try {
    const log::Quiet quiet;
    const Judgement judgement =
        judge(without(draw_scene(seed), left_out), [&](const std::string& way) { say("begins " + way + "\n"); });
    say(std::string(kVerdictNames[static_cast<int>(judgement.verdict)]) + "\n" + judgement.text + "\n");
  } catch (const std::exception& error) {  // none of ours: in drawing, or not an Error
    say(std::string("crash\nan exception that is no lithe::Error, or while drawing: ") + error.what() + "\n");
  }
  _exit(0);
}

Child start(std::uint32_t seed, const std::vector<int>& left_out, double seconds) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error(std::string("no pipe: ") + std::strerror(errno));
  const pid_t pid = fork();
  if (pid < 0) throw std::runtime_error(std::string("no process: ") + std::strerror(errno));
  if (pid == 0) {
    close(ends[0]);
    work(seed, left_out, seconds, ends[1]);
  }
  close(ends[1]);
  return {seed, pid, ends[0]};
}

/// Of a child that has ended with `status`.
SceneReport report_of(const Child& child, int status) {
  std::string text;
  char buffer[4096];
  for (ssize_t n; (n = read(child.pipe, buffer, sizeof buffer)) > 0;) text.append(buffer, static_cast<std::size_t>(n));
  close(child.pipe);
  std::string last;  // what it was at
  while (text.starts_with("begins ")) {
    const std::size_t end = text.find('\n');
    last = text.substr(7, end - 7);
    text.erase(0, end + 1);
  }
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    if (signal == SIGXCPU || signal == SIGKILL) return {"hang", "in the run " + last};
    return {"crash", std::string(strsignal(signal)) + " in the run " + last};
  }
  const std::size_t end = text.find('\n');
  if (end == std::string::npos) return {"crash", "ended by itself in the run " + last};
  return {text.substr(0, end), text.substr(end + 1, text.size() - end - 2)};
}

std::string list_of(const std::vector<int>& numbers) {
  std::string out;
  for (const int n : numbers) out += (out.empty() ? "" : ",") + std::to_string(n);
  return out;
}

void print_finding(const CampaignOptions& options, std::uint32_t seed, const SceneReport& report) {
  std::printf("---- %s: scene %u\n%s\n", report.outcome.c_str(), seed, report.text.c_str());
  std::vector<int> left_out;
  SceneReport last = report;
  if (options.shrink) {
    left_out = shrink(seed, report, options.seconds_each);
    if (!left_out.empty()) last = judge_apart(seed, left_out, options.seconds_each);
  }
  std::printf("smallest: %s\n%s", last.text.c_str(), text_of(without(draw_scene(seed), left_out)).c_str());
  std::printf("again: differential --scene %u%s%s\n", seed, left_out.empty() ? "" : " --without ",
              list_of(left_out).c_str());
  std::fflush(stdout);
}

}  // namespace

SceneReport judge_apart(std::uint32_t seed, const std::vector<int>& left_out, double seconds) {
  const Child child = start(seed, left_out, seconds);
  int status = 0;
  waitpid(child.pid, &status, 0);
  return report_of(child, status);
}

std::vector<int> shrink(std::uint32_t seed, const SceneReport& finding, double seconds) {
  std::vector<int> left_out;
  for (int i = static_cast<int>(draw_scene(seed).elements.size()) - 1; i >= 0; --i) {
    std::vector<int> more = left_out;
    more.push_back(i);
    if (without(draw_scene(seed), more).bodies.empty()) continue;
    if (judge_apart(seed, more, seconds).outcome == finding.outcome) left_out = more;
  }
  std::sort(left_out.begin(), left_out.end());
  return left_out;
}

int run_campaign(const CampaignOptions& options) {
  std::map<std::string, int> counts;
  std::map<std::string, int> refusals;  // by the first line, numbers left out
  std::vector<Child> running;
  int findings = 0;
  const std::uint32_t end = options.first + static_cast<std::uint32_t>(options.scenes);
  const InterruptGuard guard;
  for (std::uint32_t seed = options.first; seed < end || !running.empty();) {
    if (InterruptGuard::asked() != 0) {  // what is judged so far counts
      for (const Child& child : running) kill(child.pid, SIGKILL);
      break;
    }
    if (seed < end && static_cast<int>(running.size()) < options.jobs) {
      running.push_back(start(seed++, {}, options.seconds_each));
      continue;
    }
    int status = 0;
    const pid_t pid = waitpid(-1, &status, 0);
    const auto child = std::find_if(running.begin(), running.end(), [&](const Child& c) { return c.pid == pid; });
    if (child == running.end() || InterruptGuard::asked() != 0) continue;  // it may have been asked too
    const SceneReport report = report_of(*child, status);
    const std::uint32_t judged = child->seed;
    running.erase(child);
    ++counts[report.outcome];
    if (report.outcome == "refused") {
      std::string line = report.text.substr(0, report.text.find('\n'));
      line.erase(std::remove_if(line.begin(), line.end(), [](char c) { return std::isdigit(c) != 0; }), line.end());
      if (refusals[line]++ == 0) std::printf("---- refused: scene %u\n%s\n", judged, report.text.c_str());
    }
    if (!report.finding()) continue;
    ++findings;
    print_finding(options, judged, report);
  }
  std::printf("scenes from %u on:\n", options.first);
  for (const auto& [outcome, count] : counts) std::printf("%8d %s\n", count, outcome.c_str());
  for (const auto& [line, count] : refusals) std::printf("%8d refused: %s\n", count, line.c_str());
  rusage used;
  getrusage(RUSAGE_CHILDREN, &used);
  std::printf("%ld s of CPU time\n", static_cast<long>(used.ru_utime.tv_sec + used.ru_stime.tv_sec));
  return findings;
}

}  // namespace lithe::differential
