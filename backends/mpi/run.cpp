// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <thread>

#include "ranks_state.hpp"

namespace swiftgs {
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
