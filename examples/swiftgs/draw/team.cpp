// SPDX-License-Identifier: Apache-2.0
#include "draw/team.hpp"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <thread>

#include "draw/launcher.hpp"
#if defined(SWIFTGS_HAS_MPI)
#include <swiftgs/mpi/identity.hpp>
#include <swiftgs/mpi/ranks.hpp>
#if defined(SWIFTGS_HAS_CUDA)
#include <swiftgs/mpi/cuda.hpp>
#endif
#endif

namespace swiftgs::cli {

Team& Team::here() {
  static Team team;
  return team;
}

#if defined(SWIFTGS_HAS_MPI)

namespace {

std::optional<Ranks> ranks;  ///< none where this process is alone

}  // namespace

int Team::run(int argc, char** argv, const std::function<int()>& work) {
  if (!started_by_launcher()) return work();
  return run_on_ranks("swiftgs", [&](Ranks& started) {
    if (started.size() == 1) return work();
    started.require_same("the build of the tool", build_identity());
    std::string arguments;
    for (int i = 1; i < argc; ++i) arguments.append(i == 1 ? "" : " ").append(argv[i]);
    started.require_same("the command", arguments);
    if (started.rank() != 0 && !std::freopen("/dev/null", "w", stdout))
      throw std::runtime_error("/dev/null: cannot be opened");
#if defined(SWIFTGS_HAS_CUDA)
    // Ranks without a device may draw on the host: all ask, since `take_device` is collective.
    try {
      take_device(started);
    } catch (const DeviceError&) {
      if (Cuda::usable()) throw;
    }
#endif
    ranks.emplace(started);
    const int code = work();
    ranks.reset();
    return code;
  });
}

int Team::rank() const { return ranks ? ranks->rank() : 0; }
int Team::size() const { return ranks ? ranks->size() : 1; }

void Team::require_same(const std::string& what, const std::string& mine) const {
  if (ranks) ranks->require_same(what, mine);
}

void Team::require_same_file(const std::string& path) const {
  if (!ranks) return;
  // What is no file, or is not there, may be so on one rank alone.
  ranks->require_same(path, std::filesystem::is_regular_file(path) ? file_identity(path) : "no regular file");
}

std::vector<std::string> Team::gather(const std::string& mine) const { return ranks->all_gather(mine); }

void Team::add_up(std::vector<std::uint64_t>& sums) const {
  if (ranks) ranks->add_up({sums.data(), sums.size()});
}

void Team::meet(const std::function<void()>& meanwhile) const {
  if (ranks) ranks->meet(meanwhile);
}

void Team::tell_step() const {
  if (ranks) ranks->tell_step();
}

std::size_t Team::steps_told() const { return ranks ? ranks->steps_told() : 0; }

#else

int Team::run(int, char**, const std::function<int()>& work) {
  if (started_behind_others()) {
    // A launcher may end all at the first that fails: let the one that says why be it.
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    return 1;
  }
  if (started_with_others())
    throw std::runtime_error(
        "built without MPI and started by a launcher such as mpirun: each process would do all the work; "
        "expected a build with SWIFTGS_BUILD_MPI, or one process");
  return work();
}
int Team::rank() const { return 0; }
int Team::size() const { return 1; }
void Team::require_same(const std::string&, const std::string&) const {}
void Team::require_same_file(const std::string&) const {}
std::vector<std::string> Team::gather(const std::string& mine) const { return {mine}; }
void Team::add_up(std::vector<std::uint64_t>&) const {}
void Team::meet(const std::function<void()>&) const {}
void Team::tell_step() const {}
std::size_t Team::steps_told() const { return 0; }

#endif

}  // namespace swiftgs::cli
