// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <swiftgs/error.hpp>

#include "ranks_state.hpp"

namespace swiftgs {

void mpi::check(int result, const char* call) {
  if (result == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING] = "";
  int length = 0;
  MPI_Error_string(result, text, &length);
  throw MpiError(call, std::string(text, std::size_t(length)));
}

mpi::Described mpi::describe(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const std::bad_alloc&) {
    return {ErrorCode::out_of_memory, "out of memory"};
  } catch (const std::filesystem::filesystem_error& of_file) {
    return {ErrorCode::file, of_file.path1().string() + ": " + of_file.code().message()};
  } catch (const std::exception& any) {
    return {code_of(any), any.what()};
  } catch (...) {
    return {ErrorCode::internal, "unknown error"};
  }
}

Ranks::State::State(MPI_Comm of) {
  mpi::check(MPI_Comm_dup(of, &comm), "MPI_Comm_dup");
  MPI_Comm_set_errhandler(comm, MPI_ERRORS_RETURN);
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
}

Ranks::State::~State() {
  int ended = 0;
  MPI_Finalized(&ended);
  // Freeing is collective: a rank that fails alone would wait here for the others, and leaves it to the end.
  if (!ended && std::uncaught_exceptions() == 0) MPI_Comm_free(&comm);
}

Ranks ranks_of(MPI_Comm comm) { return Ranks(std::make_shared<Ranks::State>(comm)); }

int Ranks::rank() const { return state_->rank; }
int Ranks::size() const { return state_->size; }
int Ranks::rank_on_machine() const {
  MPI_Comm machine = MPI_COMM_NULL;
  mpi::check(MPI_Comm_split_type(state_->comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine),
             "MPI_Comm_split_type");
  int rank = 0;
  MPI_Comm_rank(machine, &rank);
  MPI_Comm_free(&machine);
  return rank;
}
Traffic Ranks::traffic() const { return state_->traffic; }

void Ranks::set_longest_message(std::size_t bytes) {
  if (bytes < 1 || bytes > std::size_t(1) << 30)
    detail::refuse("ranks: the longest message is ", bytes, " bytes, expected 1 to 2^30");
  state_->longest_message = bytes;
}

void Ranks::set_direct(bool direct) { state_->direct = direct; }
bool Ranks::direct() const { return state_->direct; }

bool Ranks::all(bool mine) const {
  const mpi::Waiting waiting(*state_);
  int on_all = mine;
  mpi::check(MPI_Allreduce(MPI_IN_PLACE, &on_all, 1, MPI_INT, MPI_MIN, state_->comm), "MPI_Allreduce");
  return on_all != 0;
}

void Ranks::all_gather_bytes(const void* mine, void* each, std::size_t bytes) const {
  const mpi::Waiting waiting(*state_);
  mpi::check(MPI_Allgather(mine, int(bytes), MPI_BYTE, each, int(bytes), MPI_BYTE, state_->comm),
             "MPI_Allgather");
}

std::vector<std::string> Ranks::all_gather(const std::string& mine) const {
  const std::vector<std::uint64_t> lengths = all_gather(std::uint64_t(mine.size()));
  std::vector<std::string> each(lengths.size());
  Exchange exchange(*this);
  for (int r = 0; r < size(); ++r) {
    std::string& text = each[std::size_t(r)];
    if (r == rank()) {
      text = mine;
      continue;
    }
    text.resize(lengths[std::size_t(r)]);
    exchange.receive(r, text.data(), text.size());
    exchange.send(r, mine.data(), mine.size());
  }
  exchange.wait();
  return each;
}

void Ranks::add_up(Span<std::uint64_t> sums) const {
  const mpi::Waiting waiting(*state_);
  const std::size_t at_once = state_->longest_message / sizeof(std::uint64_t) + 1;
  for (std::size_t begin = 0; begin < sums.size; begin += at_once)
    mpi::check(MPI_Allreduce(MPI_IN_PLACE, sums.data + begin, int(std::min(at_once, sums.size - begin)),
                             MPI_UINT64_T, MPI_SUM, state_->comm),
               "MPI_Allreduce");
}

void mpi::hear_step(Ranks::State& state) {
  check(MPI_Recv(nullptr, 0, MPI_BYTE, MPI_ANY_SOURCE, step_tag, state.comm, MPI_STATUS_IGNORE), "MPI_Recv");
  ++state.steps_heard;
}

void Ranks::meet(const std::function<void()>& meanwhile) const {
  MPI_Request request = MPI_REQUEST_NULL;
  const std::uint64_t mine = state_->steps_told;
  std::uint64_t told = 0;
  mpi::check(MPI_Iallreduce(&mine, &told, 1, MPI_UINT64_T, MPI_SUM, state_->comm, &request),
             "MPI_Iallreduce");
  for (int all = 0;; std::this_thread::sleep_for(std::chrono::milliseconds(10))) {
    mpi::check(MPI_Test(&request, &all, MPI_STATUS_IGNORE), "MPI_Test");
    if (all) break;
    meanwhile();
  }
  while (state_->rank == 0 && state_->steps_heard < told) mpi::hear_step(*state_);
}

void Ranks::tell_step() const {
  MPI_Request request = MPI_REQUEST_NULL;
  mpi::check(MPI_Isend(nullptr, 0, MPI_BYTE, 0, mpi::step_tag, state_->comm, &request), "MPI_Isend");
  mpi::check(MPI_Request_free(&request), "MPI_Request_free");
  ++state_->steps_told;
}

std::size_t Ranks::steps_told() const {
  for (int waits = 1;; mpi::hear_step(*state_)) {
    mpi::check(MPI_Iprobe(MPI_ANY_SOURCE, mpi::step_tag, state_->comm, &waits, MPI_STATUS_IGNORE),
               "MPI_Iprobe");
    if (!waits) break;
  }
  const std::uint64_t before = std::exchange(state_->steps_asked, state_->steps_heard);
  return std::size_t(state_->steps_heard - before);
}

void Ranks::require_same(const std::string& what, const std::string& mine) const {
  const std::vector<std::string> each = all_gather(mine);
  for (std::size_t r = 1; r < each.size(); ++r)
    if (each[r] != each[0])
      detail::refuse(what, " is '", each[r], "' on rank ", r, ", expected '", each[0], "' as on rank 0");
}

void Failure::tell(const Ranks& ranks) const {
  std::string mine;  // the number of the code, and the text behind it
  if (error_) {
    const auto [code, text] = mpi::describe(error_);
    mine = char(code) + text;
  }
  const std::vector<std::string> each = ranks.all_gather(mine);
  if (error_) std::rethrow_exception(error_);
  for (std::size_t r = 0; r < each.size(); ++r)
    if (!each[r].empty()) throw RankError(int(r), ErrorCode(each[r][0]), each[r].substr(1));
  throw detail::ErrorAs<std::logic_error>(ErrorCode::internal,
                                          "ranks: one was said to have failed, expected its message");
}

namespace {

/// How long a rank that fails because of another waits for that one to end all.
constexpr std::chrono::milliseconds patience{500};

/// Often all ranks fail alike: the first says so, and ends the others before they do.
void let_others_speak(const Ranks& ranks) {
  if (ranks.rank() != 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(150 + std::min(ranks.rank(), 100)));
}

/// Prints one line and ends all ranks. Others may be anywhere: MPI is not ended in order.
[[noreturn]] void end_all(const std::string& program, const Ranks& ranks, std::string text) {
  let_others_speak(ranks);
  std::replace(text.begin(), text.end(), '\n', ' ');
  std::fflush(stdout);
  std::fprintf(stderr, "%s: rank %d of %d: %s\n", program.c_str(), ranks.rank(), ranks.size(), text.c_str());
  std::fflush(stderr);
  MPI_Abort(MPI_COMM_WORLD, 1);
  std::_Exit(1);
}

}  // namespace

int run_on_ranks(const std::string& program, const std::function<int(Ranks&)>& work) {
  int provided = 0;
  // MPI's own handler ends the program at any error before there are ranks.
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
  int code = 0;
  {
    Ranks ranks = ranks_of(MPI_COMM_WORLD);
    try {
      code = work(ranks);
    } catch (const RankError& error) {
      std::this_thread::sleep_for(patience);  // the rank that failed says so itself
      end_all(program, ranks, error.what());
    } catch (...) {
      end_all(program, ranks, mpi::describe(std::current_exception()).text);
    }
  }
  MPI_Finalize();
  return code;
}

}  // namespace swiftgs
