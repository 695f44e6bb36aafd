// SPDX-License-Identifier: Apache-2.0

// Arrays from device to device by NCCL. Who sends what to whom is agreed by MPI before, and faults of frames
// are told by MPI after. A call of NCCL that fails ends the program, as one of MPI does.
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <cuda_runtime_api.h>

#include <swiftgs/mpi/cuda.hpp>

#include "cuda/nccl_functions.hpp"
#include "ranks_state.hpp"

namespace swiftgs {
namespace {

void check(cudaError_t result, const char* call) {
  if (result == cudaSuccess) return;
  cudaGetLastError();
  throw MpiError(call, cudaGetErrorString(result));
}

void check(ncclResult_t result, const char* call) {
  if (result != ncclSuccess)
    throw MpiError(call,
                   std::string(nccl()->get_error_string(result)) + ", " + nccl()->get_last_error(nullptr));
}

/// The devices of all ranks, and a stream of this rank's on which arrays go between them. Belongs to the
/// device that was current when it was made. Made where `nccl()` is.
class Devices {
 public:
  explicit Devices(int device) : device_(device) {
    // High priority: other ranks wait for this stream. Non-blocking: backends work on the default stream,
    // which would otherwise wait for it.
    int least = 0, greatest = 0;
    check(cudaDeviceGetStreamPriorityRange(&least, &greatest), "cudaDeviceGetStreamPriorityRange");
    check(cudaStreamCreateWithPriority(&stream_, cudaStreamNonBlocking, greatest),
          "cudaStreamCreateWithPriority");
    for (cudaEvent_t* event : {&submitted_, &done_[0], &done_[1]})
      check(cudaEventCreateWithFlags(event, cudaEventDisableTiming), "cudaEventCreateWithFlags");
  }
  /// Collective.
  void join(const Ranks& ranks, const ncclUniqueId& id) {
    check(nccl()->comm_init_rank(&comm_, ranks.size(), id, ranks.rank()), "ncclCommInitRank");
  }
  ~Devices() {
    // Destroying waits for the other ranks, which a rank that fails alone must not.
    if (comm_ && std::uncaught_exceptions() == 0)
      nccl()->comm_destroy(comm_);
    else if (comm_)
      nccl()->comm_abort(comm_);
    for (cudaEvent_t event : {submitted_, done_[0], done_[1]}) cudaEventDestroy(event);
    cudaStreamDestroy(stream_);
  }
  Devices(const Devices&) = delete;
  Devices& operator=(const Devices&) = delete;

  bool joins(int device) const { return comm_ && device == device_; }

  std::uint64_t begin(Span<const DirectLink::Message> messages, cudaStream_t behind) {
    require_joined();
    try {
      check(cudaEventRecord(submitted_, behind), "cudaEventRecord");
      check(cudaStreamWaitEvent(stream_, submitted_, 0), "cudaStreamWaitEvent");
      if (messages.size != 0) check(exchange(messages), "ncclSend and ncclRecv");
      check(cudaEventRecord(done_[++begun_ % 2], stream_), "cudaEventRecord");
    } catch (const MpiError& error) {
      give_up(error);
    }
    return begun_;
  }

  void order(std::uint64_t begun, cudaStream_t later) {
    require_joined();
    // Of two exchanges ago and more this is the event of a later one, which comes behind it.
    try {
      check(cudaStreamWaitEvent(later, done_[begun % 2], 0), "cudaStreamWaitEvent");
    } catch (const MpiError& error) {
      give_up(error);
    }
  }

  bool test(std::uint64_t begun) {
    require_joined();
    try {
      const cudaError_t result = cudaEventQuery(done_[begun % 2]);
      if (result == cudaSuccess) return true;
      cudaGetLastError();  // or the next launch would be taken for a failed one
      if (result != cudaErrorNotReady) check(result, "cudaEventQuery");
      ncclResult_t failed = ncclSuccess;
      check(nccl()->comm_get_async_error(comm_, &failed), "ncclCommGetAsyncError");
      check(failed, "NCCL between devices");
    } catch (const MpiError& error) {
      give_up(error);
    }
    return false;
  }

 private:
  /// All in one group: whichever end of a pair comes first, none waits for another pair's.
  ncclResult_t exchange(Span<const DirectLink::Message> messages) {
    ncclResult_t result = nccl()->group_start();
    if (result != ncclSuccess) return result;
    for (const DirectLink::Message& message : messages) {
      const auto [rank, bytes, from, to] = message;
      result = from ? nccl()->send(from, bytes, ncclUint8, rank, comm_, stream_)
                    : nccl()->recv(to, bytes, ncclUint8, rank, comm_, stream_);
      if (result != ncclSuccess) break;
    }
    const ncclResult_t ended = nccl()->group_end();  // a group that was started must end
    return result != ncclSuccess ? result : ended;
  }

  /// Stops what this rank's device does for others, and waits for from them, for good.
  [[noreturn]] void give_up(const MpiError& error) {
    nccl()->comm_abort(std::exchange(comm_, nullptr));
    failure_ = std::make_exception_ptr(error);
    std::rethrow_exception(failure_);
  }
  void require_joined() const {
    if (failure_) std::rethrow_exception(failure_);
  }

  int device_;
  ncclComm_t comm_ = nullptr;
  cudaStream_t stream_ = nullptr;
  cudaEvent_t submitted_ = nullptr, done_[2] = {};
  std::uint64_t begun_ = 0;  ///< exchanges
  std::exception_ptr failure_;
};

class NcclLink : public DirectLink {
 public:
  NcclLink(std::shared_ptr<Devices> devices, cudaStream_t behind)
      : devices_(std::move(devices)), behind_(behind) {}

  std::string_view name() const override { return "nccl"; }
  std::uint64_t begin(Span<const Message> messages, void* stream) override {
    return devices_->begin(messages, stream ? static_cast<cudaStream_t>(stream) : behind_);
  }
  void order(std::uint64_t begun) override { devices_->order(begun, behind_); }
  bool test(std::uint64_t begun) override { return devices_->test(begun); }

 private:
  std::shared_ptr<Devices> devices_;
  cudaStream_t behind_;  ///< the backend's
};

/// What a rank says of its device.
struct Place {
  char machine[MPI_MAX_PROCESSOR_NAME] = {};
  char bus[32] = {};
  int device = 0;
  int direct = 0;  ///< whether it may
  int shares = 0;  ///< whether NCCL was told that ranks may share a device

  bool operator==(const Place& other) const {
    return std::strcmp(machine, other.machine) == 0 && std::strcmp(bus, other.bus) == 0;
  }
};

/// 23007 for 2.30.7.
int nccl_version() {
  int version = 0;
  check(nccl()->get_version(&version), "ncclGetVersion");
  return version;
}

Place place_of(const Ranks& ranks) {
  Place place{.direct = ranks.direct() && nccl()};
  const char* const shares = std::getenv("NCCL_MULTI_RANK_GPU_ENABLE");
  place.shares = place.direct != 0 && shares && std::atoi(shares) != 0 && nccl_version() >= 23000;
  int length = 0;
  mpi::check(MPI_Get_processor_name(place.machine, &length), "MPI_Get_processor_name");
  check(cudaGetDevice(&place.device), "cudaGetDevice");
  check(cudaDeviceGetPCIBusId(place.bus, sizeof place.bus, place.device), "cudaDeviceGetPCIBusId");
  return place;
}

/// Whether NCCL may join them: it knows ranks by their devices, unless it was told otherwise.
bool can_be_joined(const std::vector<Place>& places) {
  bool can = places.size() > 1;
  for (std::size_t r = 0; r < places.size(); ++r) {
    can = can && places[r].direct != 0;
    for (std::size_t other = 0; other < r; ++other)
      can = can && (!(places[r] == places[other]) || (places[r].shares && places[other].shares));
  }
  return can;
}

}  // namespace

std::unique_ptr<DirectLink> direct_link(const Ranks& ranks, Cuda& cuda) {
  Place mine;
  Failure failure;
  failure.guard([&] { mine = place_of(ranks); });
  failure.agree(ranks);
  if (!can_be_joined(ranks.all_gather(mine))) return nullptr;
  auto devices = std::static_pointer_cast<Devices>(ranks.state().devices);
  if (!ranks.all(devices && devices->joins(mine.device))) {
    ncclUniqueId id{};
    failure.guard([&] {
      devices = std::make_shared<Devices>(mine.device);
      if (ranks.rank() == 0) check(nccl()->get_unique_id(&id), "ncclGetUniqueId");
    });
    failure.agree(ranks);
    devices->join(ranks, ranks.all_gather(id)[0]);
    ranks.state().devices = devices;
  }
  return std::make_unique<NcclLink>(std::move(devices), cuda.stream());
}

}  // namespace swiftgs
