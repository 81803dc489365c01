// The one home of MPI. Built without it (no LITHE_MPI), a process is always alone.
#include "engine/study/sweep_internal.h"

#ifndef LITHE_MPI

namespace lithe {
SweepRanks* SweepRanks::find() { return nullptr; }
}  // namespace lithe

#else

#define OMPI_SKIP_MPICXX 1  // the C interface alone: the C++ one left the standard in 2012
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace lithe {
namespace {

constexpr std::chrono::milliseconds kBetweenLooks{1};  // at messages; looking takes 2 % of a processor

// What ranks say to each other. Rank 0 deals; the others know it alone.
enum class Say : int {
  hello,    // to 0: here is a rank with so many threads, and the fingerprint of its parameters
  point,    // from 0: compute this one
  outcome,  // to 0: it is done; from 0, once all are: what it came to
  over,     // from 0: all are told
  leaving,  // to 0: this rank's program ends; from 0: so do all
};

using Bytes = std::vector<char>;

/// Numbers as they lie in memory, texts by their length: ranks run one program on machines of one kind.
class Writer {
 public:
  template <class Number>
  Writer& add(Number value) {
    const char* raw = reinterpret_cast<const char*>(&value);
    bytes_.insert(bytes_.end(), raw, raw + sizeof value);
    return *this;
  }
  Writer& add(const std::string& text) {
    add(text.size());
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    return *this;
  }
  const Bytes& bytes() const { return bytes_; }

 private:
  Bytes bytes_;
};

class Reader {
 public:
  explicit Reader(const Bytes& bytes) : at_(bytes.data()) {}
  template <class Number>
  Number number() {
    Number value;
    std::memcpy(&value, at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  std::string text() {
    const auto size = number<std::size_t>();
    at_ += size;
    return std::string(at_ - size, size);
  }

 private:
  const char* at_;
};

Bytes encoded(const SweepOutcome& outcome) {
  Writer out;
  out.add(outcome.row).add(outcome.seconds).add(outcome.values.size());
  for (const SweepValue& value : outcome.values) out.add(value.name).add(value.value);
  out.add(outcome.failure.has_value());
  if (const auto& f = outcome.failure) out.add(f->point).add(f->what).add(f->where).add(f->fix);
  return out.bytes();
}

SweepOutcome decoded(const Bytes& bytes) {
  Reader in(bytes);
  SweepOutcome outcome;
  outcome.row = in.number<int>();
  outcome.seconds = in.number<double>();
  outcome.values.resize(in.number<std::size_t>());
  for (SweepValue& value : outcome.values) value.name = in.text(), value.value = in.number<double>();
  if (in.number<bool>()) {
    SweepFailure& f = outcome.failure.emplace();
    f.row = outcome.row;
    for (std::string* text : {&f.point, &f.what, &f.where, &f.fix}) *text = in.text();
  }
  return outcome;
}

struct Message {
  Say say;
  int from;
  Bytes bytes;
};

/// MPI from the first sweep to the end of the process. All calls come from the thread that sweeps.
class MpiRanks final : public SweepRanks {
 public:
  MpiRanks() {
    int initialized = 0;
    MPI_Initialized(&initialized);
    ours_ = !initialized;
    int granted = 0;
    if (ours_) MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &granted);
    MPI_Comm_dup(MPI_COMM_WORLD, &world_);
    MPI_Comm_rank(world_, &rank_);
    MPI_Comm_size(world_, &size_);
    MPI_Comm machine;
    MPI_Comm_split_type(world_, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
    MPI_Comm_size(machine, &on_this_machine_);
    MPI_Comm_free(&machine);
  }

  /// The program's end. MPI_Finalize waits for all ranks: it is called only once all have come here.
  ~MpiRanks() override {
    if (!ours_) return;
    if (rank_ == 0) {
      for (int other = 1; other < size_; ++other)
        if (const Message message = wait(); message.say != Say::leaving) abort(0, message.from);
      for (int other = 1; other < size_; ++other) send(other, Say::leaving);
    } else {
      send(0, Say::leaving);
      wait();
    }
    MPI_Comm_free(&world_);
    MPI_Finalize();
  }

  int rank() const override { return rank_; }
  int size() const { return size_; }
  int ranks_on_this_machine() const override { return on_this_machine_; }

  void share(SweepThreads& team, int count, std::uint64_t fingerprint, const SweepListener& listener,
             const std::function<void()>& meanwhile) override {
    if (rank_ == 0)
      deal(team, count, fingerprint, listener, meanwhile);
    else
      serve(team, fingerprint, listener);
  }

 private:
  /// Hands every thread of every rank a point at a time.
  void deal(SweepThreads& team, int count, std::uint64_t fingerprint, const SweepListener& listener,
            const std::function<void()>& meanwhile) {
    std::vector<Bytes> told(count);
    int next = 0, finished = 0, here = 1, threads = team.size();
    const auto hand_out = [&](int to) {
      if (next == count) return;
      if (to == 0)
        team.add(next++);
      else
        send(to, Say::point, Writer().add(next++).bytes());
    };
    const auto keep = [&](SweepOutcome outcome, Bytes bytes) {
      told[outcome.row] = std::move(bytes);
      ++finished;
      listener(std::move(outcome), threads);
    };
    for (int i = 0; i < team.size(); ++i) hand_out(0);
    while (finished < count || here < size_) {
      for (SweepOutcome& outcome : team.take(kBetweenLooks)) {
        Bytes bytes = encoded(outcome);
        keep(std::move(outcome), std::move(bytes));
        hand_out(0);
      }
      while (std::optional<Message> message = find_message()) {
        if (message->say == Say::hello) {
          Reader in(message->bytes);
          const int others = in.number<int>();
          if (in.number<std::uint64_t>() != fingerprint)
            end_all("rank " + std::to_string(message->from) + " sweeps other points than rank 0",
                    "make the parameters the same on every rank: no clock, no random seed, no rank in them");
          ++here;
          threads += others;
          for (int i = 0; i < others; ++i) hand_out(message->from);
        } else if (message->say == Say::outcome) {
          keep(decoded(message->bytes), message->bytes);
          hand_out(message->from);
        } else {
          abort(message->from, 0);
        }
      }
      meanwhile();
    }
    for (int other = 1; other < size_; ++other) {
      for (const Bytes& bytes : told) send(other, Say::outcome, bytes);
      send(other, Say::over);
    }
  }

  /// Computes what rank 0 hands out, until it tells of all points.
  void serve(SweepThreads& team, std::uint64_t fingerprint, const SweepListener& listener) {
    send(0, Say::hello, Writer().add(team.size()).add(fingerprint).bytes());
    while (true) {
      for (const SweepOutcome& outcome : team.take(kBetweenLooks)) send(0, Say::outcome, encoded(outcome));
      while (const std::optional<Message> message = find_message()) {
        if (message->say == Say::over) return;
        if (message->say == Say::point)
          team.add(Reader(message->bytes).number<int>());
        else
          listener(decoded(message->bytes), team.size());
      }
    }
  }

  void send(int to, Say say, const Bytes& bytes = {}) {
    MPI_Send(bytes.data(), static_cast<int>(bytes.size()), MPI_CHAR, to, static_cast<int>(say), world_);
  }

  std::optional<Message> find_message() {
    int found = 0;
    MPI_Status status;
    MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, world_, &found, &status);
    if (!found) return {};
    int size = 0;
    MPI_Get_count(&status, MPI_CHAR, &size);
    Message message{static_cast<Say>(status.MPI_TAG), status.MPI_SOURCE, Bytes(size)};
    MPI_Recv(message.bytes.data(), size, MPI_CHAR, message.from, status.MPI_TAG, world_, MPI_STATUS_IGNORE);
    return message;
  }

  Message wait() {
    while (true) {
      if (std::optional<Message> message = find_message()) return *std::move(message);
      std::this_thread::sleep_for(kBetweenLooks);
    }
  }

  /// One rank's program has come to its end while another sweeps.
  void abort(int ended, int sweeping) {
    end_all("rank " + std::to_string(ended) + " ended its program while rank " + std::to_string(sweeping) + " sweeps",
            "see what that rank said before; all ranks must run the same sweeps");
  }

  void end_all(const std::string& what, const std::string& fix) {
    std::fprintf(stderr, "%s\n", SimulationError(what, "sweep, rank " + std::to_string(rank_), fix).what());
    MPI_Abort(world_, 1);
    std::abort();  // MPI_Abort is not declared to end the process
  }

  MPI_Comm world_ = MPI_COMM_NULL;  // our messages among themselves
  int rank_ = 0, size_ = 1, on_this_machine_ = 1;
  bool ours_ = false;
};

/// Whether a launcher started this process as one of several: mpirun of Open MPI or of MPICH, srun. Asked of the
/// environment, so that a run without one never starts MPI.
bool is_launched() {
  const auto size = [](const char* variable) {
    const char* text = std::getenv(variable);
    return text ? std::atoi(text) : 0;
  };
  if (size("OMPI_COMM_WORLD_SIZE") > 0) return size("OMPI_COMM_WORLD_SIZE") > 1;
  return size("PMI_SIZE") > 1 || std::getenv("PMIX_RANK");
}

}  // namespace

SweepRanks* SweepRanks::find() {
  // MPI starts and ends once a process, so this lasts as long.
  static const std::unique_ptr<MpiRanks> ranks = is_launched() ? std::make_unique<MpiRanks>() : nullptr;
  return ranks && ranks->size() > 1 ? ranks.get() : nullptr;
}

}  // namespace lithe

#endif
