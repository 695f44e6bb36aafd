// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <string>

#include <swiftgs/error.hpp>
#include <swiftgs/mpi/comm.hpp>

namespace swiftgs {

struct Ranks::State {
  explicit State(MPI_Comm of);
  ~State();
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  MPI_Comm comm = MPI_COMM_NULL;
  int rank = 0, size = 1;
  std::size_t longest_message = std::size_t(1) << 30;
  Traffic traffic;
  bool direct = true;
  std::shared_ptr<void> devices;  ///< that a direct link joins; made once, since that takes long
  std::uint64_t steps_told = 0;   ///< by this rank
  std::uint64_t steps_heard = 0;  ///< by this rank, of all others
  std::uint64_t steps_asked = 0;  ///< steps heard that `steps_told` has returned
};

namespace mpi {

/// Of messages of an `Exchange`, and of those that tell steps.
inline constexpr int data_tag = 0, step_tag = 1;

/// Throws `MpiError` unless a call of MPI succeeded.
void check(int result, const char* call);

/// What a line about an error says of it.
struct Described {
  ErrorCode code;
  std::string text;
};
Described describe(const std::exception_ptr& error);

/// Receives one step that another rank tells, and waits for it.
void hear_step(Ranks::State& state);

/// Adds the time of its life to what a rank has waited.
class Waiting {
 public:
  explicit Waiting(Ranks::State& state) : state_(state) {}
  ~Waiting() {
    const auto passed = std::chrono::steady_clock::now() - begun_;
    state_.traffic.waiting_ns += std::uint64_t(std::chrono::nanoseconds(passed).count());
  }
  Waiting(const Waiting&) = delete;
  Waiting& operator=(const Waiting&) = delete;

 private:
  Ranks::State& state_;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
};

}  // namespace mpi
}  // namespace swiftgs
