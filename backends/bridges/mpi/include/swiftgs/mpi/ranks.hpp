// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/span.hpp>

namespace swiftgs {

/// A call to MPI failed, or one to what carries messages in its place. `what()` holds the call and its own
/// text for the error. Its code is that of a device.
class SWIFTGS_API MpiError : public detail::ErrorAs<std::runtime_error> {
 public:
  MpiError(const std::string& call, const std::string& text)
      : ErrorAs(ErrorCode::device, call + ": " + text) {}
};

/// Another rank failed, so that this one cannot go on. The code is that of its error, and `what()` its
/// message behind its number.
class SWIFTGS_API RankError : public detail::ErrorAs<std::runtime_error> {
 public:
  RankError(int rank, ErrorCode code, const std::string& text)
      : ErrorAs(code, "rank " + std::to_string(rank) + ": " + text), rank_(rank) {}

  int rank() const { return rank_; }

 private:
  int rank_;
};

/// Bytes that a rank has sent and received, and how long it has waited for other ranks.
struct Traffic {
  std::uint64_t sent_bytes = 0, received_bytes = 0;
  std::uint64_t messages = 0;    ///< sent
  std::uint64_t waiting_ns = 0;  ///< in calls that other ranks had to answer @units{nanoseconds}

  Traffic operator-(const Traffic& o) const {
    return {sent_bytes - o.sent_bytes, received_bytes - o.received_bytes, messages - o.messages,
            waiting_ns - o.waiting_ns};
  }
};

/// Processes that work together, numbered from 0: this one's number, and how it reaches the others. This
/// header needs no MPI; <swiftgs/mpi/comm.hpp> makes ranks of a communicator.
///
/// Copies share a communicator of their own, so their messages never mix with the program's. One thread at a
/// time may use it. Functions are collective, called by all ranks in one order, unless they say otherwise.
/// All throw `MpiError`.
class SWIFTGS_API Ranks {
 public:
  struct State;
  explicit Ranks(std::shared_ptr<State> state) : state_(std::move(state)) {}

  int rank() const;
  int size() const;
  /// Number of this rank among the ranks of its machine, from 0. Collective.
  int rank_on_machine() const;

  /// Whether `mine` holds on all ranks.
  bool all(bool mine) const;

  /// Gathers `mine` of each rank, in the order of ranks.
  std::vector<std::string> all_gather(const std::string& mine) const;
  template <class T>
  std::vector<T> all_gather(const T& mine) const {
    static_assert(std::is_trivially_copyable_v<T>, "ranks exchange plain data");
    std::vector<T> each(static_cast<std::size_t>(size()));
    all_gather_bytes(&mine, each.data(), sizeof(T));
    return each;
  }

  /// Replaces each element by its sum over all ranks.
  void add_up(Span<std::uint64_t> sums) const;

  /// Throws `InvalidArgument` on all ranks unless all bring the same text for `what`.
  void require_same(const std::string& what, const std::string& mine) const;

  /// Returns when all ranks have called it, and rank 0 has heard all steps that they told before; calls
  /// `meanwhile` now and then.
  void meet(const std::function<void()>& meanwhile) const;

  /// Tells rank 0 that some step is done, and does not wait for it to hear. Not collective.
  void tell_step() const;
  /// On rank 0: how many steps others have told since this was last asked. Not collective.
  std::size_t steps_told() const;

  /// Traffic of this rank since its communicator was made. Not collective.
  Traffic traffic() const;

  /// Longest message: longer ones are cut, since MPI counts in 31 bits. The same on all ranks; tests lower
  /// it. @units{bytes}
  void set_longest_message(std::size_t bytes);

  /// Whether renderers that are made from now on let devices exchange splats without the host, where they
  /// can: true until this is called. The same on all ranks. Not collective.
  void set_direct(bool direct);
  bool direct() const;

  State& state() const { return *state_; }

 private:
  void all_gather_bytes(const void* mine, void* each, std::size_t bytes) const;

  std::shared_ptr<State> state_;
};

class DirectLink;

/// Messages under way between ranks. Messages from one rank to another arrive in the order in which they were
/// begun, so sender and receiver begin them in the same order. Memory of a message is in use until `wait`.
class SWIFTGS_API Exchange {
 public:
  /// Messages go by `link`, which outlives them, on all ranks or on none.
  explicit Exchange(const Ranks& ranks, DirectLink* link = nullptr);
  /// Waits for what is under way.
  ~Exchange();
  Exchange(const Exchange&) = delete;
  Exchange& operator=(const Exchange&) = delete;

  void send(int rank, const void* from, std::size_t bytes);
  void receive(int rank, void* to, std::size_t bytes);

  /// Sends elements [begins[r], begins[r + 1]) of `from` to each other rank r, and receives as many as
  /// `to_begins` says. What a rank has for itself stays where it is.
  void all_to_all(const void* from, Span<const std::uint64_t> from_begins, void* to,
                  Span<const std::uint64_t> to_begins, std::size_t element_bytes);

  /// Gives the link, if there is one, all messages named so far, to begin as `DirectLink::begin` says; called
  /// once, and by all ranks. Messages of MPI are under way as soon as they are named.
  void begin(void* stream = nullptr);

  /// Orders later work of the link's backend after all messages. Without a link it waits for them.
  void join();

  /// Lets messages go on, as some MPIs need from time to time. Returns whether all have arrived.
  bool test();
  /// Returns when all that was begun has been sent and received.
  void wait();

 private:
  struct Requests;
  Ranks ranks_;
  DirectLink* link_;
  std::unique_ptr<Requests> requests_;
};

/// An error of this rank, which all ranks learn before any of them goes on.
class SWIFTGS_API Failure {
 public:
  /// Calls `f`, unless an earlier call failed, and keeps its exception. Passes on an `MpiError`, since ranks
  /// cannot tell each other about it.
  template <class F>
  void guard(const F& f) {
    if (error_) return;
    try {
      f();
    } catch (const MpiError&) {
      throw;
    } catch (...) {
      error_ = std::current_exception();
    }
  }
  explicit operator bool() const { return bool(error_); }

  /// Throws on all ranks if one has failed: on that rank its error, `RankError` on the others.
  void agree(const Ranks& ranks) const {
    if (!ranks.all(!error_)) tell(ranks);
  }
  /// Throws as `agree` does where all ranks know that one has failed.
  [[noreturn]] void tell(const Ranks& ranks) const;

 private:
  std::exception_ptr error_;
};

/// Runs `work` on all processes that a launcher such as mpirun started, and returns what it returns. Starts
/// and ends MPI.
///
/// If `work` throws, one line on standard error names the program, the rank and the error, and all ranks end
/// with exit code 1.
SWIFTGS_API int run_on_ranks(const std::string& program, const std::function<int(Ranks&)>& work);

}  // namespace swiftgs
