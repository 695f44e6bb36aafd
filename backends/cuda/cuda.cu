// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include <cuda/atomic>
#include <cuda_runtime_api.h>

#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/stages.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/sort.hpp>

#include "state.hpp"

namespace swiftgs {

namespace {
void* allocate_pinned(std::size_t bytes) {
  void* memory = nullptr;
  check_cuda(cudaMallocHost(&memory, bytes), "cudaMallocHost");
  return memory;
}
}  // namespace

void Cuda::State::Side::make() {
  const auto event = [](auto& owner) {
    cudaEvent_t made = nullptr;
    check_cuda(cudaEventCreateWithFlags(&made, cudaEventDisableTiming), "cudaEventCreateWithFlags");
    owner.reset(made);
  };
  event(begun), event(ended);
  cudaStream_t made = nullptr;
  check_cuda(cudaStreamCreateWithFlags(&made, cudaStreamNonBlocking), "cudaStreamCreateWithFlags");
  stream.reset(made);
}

void Cuda::State::join() {
  side.forked = false;
  check_cuda(cudaEventRecord(side.ended.get(), side.stream.get()), "cudaEventRecord");
  check_cuda(cudaStreamWaitEvent(stream, side.ended.get()), "cudaStreamWaitEvent");
}

void Cuda::State::wait() const { check_cuda(cudaStreamSynchronize(stream), "cudaStreamSynchronize"); }

void Cuda::State::copy_to_host(const void* from, void* to, std::size_t bytes) {
  if (bytes == 0) return;
  const bool is_short = bytes <= staging_bytes;
  if (is_short && !staging) staging.reset(static_cast<std::byte*>(allocate_pinned(staging_bytes)));
  check_cuda(cudaMemcpyAsync(is_short ? staging.get() : to, from, bytes, cudaMemcpyDeviceToHost, stream),
             "cudaMemcpyAsync to the host");
  wait();
  if (is_short) std::memcpy(to, staging.get(), bytes);
}

bool Cuda::usable() {
  static const bool usable = [] {
    int devices = 0;
    cudaFuncAttributes kernel{};
    const bool found = cudaGetDeviceCount(&devices) == cudaSuccess && devices > 0 &&
                       cudaFuncGetAttributes(&kernel, kernels::for_each<ClearRanges>) == cudaSuccess;
    if (!found) cudaGetLastError();
    return found;
  }();
  return usable;
}

std::string Cuda::device_name() const {
  int device = 0;
  check_cuda(cudaGetDevice(&device), "cudaGetDevice");
  cudaDeviceProp properties{};
  check_cuda(cudaGetDeviceProperties(&properties, device), "cudaGetDeviceProperties");
  return properties.name;
}

Cuda::Cuda(cudaStream_t stream, const MemoryHook& memory) {
  validate(memory);
  state_ = std::make_unique<State>(stream, memory);
}
Cuda::~Cuda() = default;
Cuda::Cuda(Cuda&&) noexcept = default;
Cuda& Cuda::operator=(Cuda&&) noexcept = default;

cudaStream_t Cuda::stream() const { return state_->stream; }

const MemoryHook& Cuda::memory_hook() const { return state_->memory; }

void Cuda::trim() {
  wait();
  State& s = *state_;
  s.staging.reset();
  trim_parts(*this, s.temporary, s.total, s.raster, s.sorts);
}

void Cuda::check_not_captured(const char* call) const { state_->check_not_captured(call); }

bool Cuda::State::being_captured(const char* call) const {
  cudaStreamCaptureStatus status = cudaStreamCaptureStatusNone;
  const cudaError_t asked = cudaStreamIsCapturing(stream, &status);
  if (asked == cudaSuccess) return status != cudaStreamCaptureStatusNone;
  cudaGetLastError();
  // The default stream is never captured itself, but using it breaks the capture of streams that it waits
  // for.
  if (asked == cudaErrorStreamCaptureImplicit)
    throw DeviceError(call,
                      "a stream that waits for the default stream is being captured into a CUDA graph, "
                      "expected none while the default stream is used");
  return false;  // any other error is that of whichever call comes next
}

void Cuda::State::check_not_captured(const char* call) const {
  if (being_captured(call))
    throw DeviceError(call,
                      "the stream is being captured into a CUDA graph, expected a stream that is not, "
                      "since the host would wait for it");
}

namespace kernels {
/// See `Cuda::settle`. A report in host memory is seen there sooner than the end of a copy would be.
__global__ void settle(const LastCounters<FrameCounts> counts, const Limits limits, FrameTotals* totals,
                       const std::uint32_t* raster_word, Mailbox* mailbox) {
  await_earlier();
  const FrameCounts found = counts.get();
  FrameReport report{found.visible, found.intersections, 0};
  report.overflowed = !limits.fit(report) || found.intersections > max_intersections;
  const bool fits = report.overflowed == 0;
  *totals = {report, fits ? std::uint32_t(found.visible) : 0, fits ? std::uint32_t(found.intersections) : 0};
  if (limits.report) *limits.report = report;
  if (!mailbox) return;
  mailbox->report = report;
  mailbox->raster_word = raster_word ? *raster_word : 0;
  cuda::atomic_ref<std::uint32_t, cuda::thread_scope_system>(mailbox->posted)
      .store(1, cuda::memory_order_release);
}
}  // namespace kernels

Views store_views(Cuda& cuda, Span<const View> views, ViewStorage<Cuda>& storage, ViewAccess access) {
  storage.each.assign(views.begin(), views.end());
  number_tiles({storage.each.data(), storage.each.size()});
  Views out(storage.each.data(), storage.each.size());
  if (out.size() == 1 && access == ViewAccess::any) return out;
  cuda.check_not_captured("store_views");
  storage.stored.reset(out.size());
  // The host's memory may change again as soon as this returns, since it is not pinned.
  check_cuda(cudaMemcpyAsync(storage.stored.data(), out.each.data, out.size() * sizeof(View),
                             cudaMemcpyHostToDevice, cuda.stream()),
             "cudaMemcpyAsync of views");
  out.stored = storage.stored.data();
  return out;
}

StoredScenes store_scenes(Cuda& cuda, const PlacedScenes& scenes, Span<const View> views,
                          SceneStorage<Cuda>& storage, ViewAccess access) {
  const bool all_show = std::all_of(
      views.begin(), views.end(), [&](const View& view) { return scenes.shown(view).size == scenes.size(); });
  if (scenes.is_alone() && all_show && access == ViewAccess::any) return StoredScenes(scenes.each()[0]);
  number_gaussians(scenes.each(), storage.each);
  cuda.check_not_captured("store_scenes");
  storage.stored.reset(std::max<std::size_t>(storage.each.size(), 1));
  if (!storage.each.empty())
    // The host's memory may change again as soon as this returns, since it is not pinned.
    check_cuda(
        cudaMemcpyAsync(storage.stored.data(), storage.each.data(), storage.each.size() * sizeof(StoredScene),
                        cudaMemcpyHostToDevice, cuda.stream()),
        "cudaMemcpyAsync of placed scenes");
  return StoredScenes(storage.each, storage.stored.data());
}

Cuda::Fork Cuda::fork() {
  State::Side& side = state_->side;
  if (side.forked) throw OrderError("fork: expected the fork before to be joined");
  side.captured = state_->being_captured("fork");
  if (!side.stream) side.make();
  check_cuda(cudaEventRecord(side.begun.get(), stream()), "cudaEventRecord");
  check_cuda(cudaStreamWaitEvent(side.stream.get(), side.begun.get()), "cudaStreamWaitEvent");
  side.forked = true;
  return Fork(state_.get());
}

cudaStream_t Cuda::Fork::stream() const { return state_->side.stream.get(); }

void Cuda::Fork::join() {
  if (!state_) return;
  // Events of before a capture do not belong into it.
  if (!state_->side.captured) state_->check_not_captured("join");
  std::exchange(state_, nullptr)->join();
}

Cuda::Fork::~Fork() {
  try {
    join();
  } catch (const DeviceError&) {
    // There is nobody left to tell. Work of the next fork comes after this one's, on the same stream.
    if (state_) state_->side.forked = false;
  }
}

void Cuda::download_bytes(const void* from, void* to, std::size_t bytes) const {
  if (bytes != 0) check_not_captured("download");
  state_->copy_to_host(from, to, bytes);
}

void Cuda::wait() const {
  check_not_captured("wait");
  state_->wait();
}

MemoryUse Cuda::memory_use() {
  std::size_t free = 0, total = 0;
  check_cuda(cudaMemGetInfo(&free, &total), "cudaMemGetInfo");
  return {total - free, total};
}

void Cuda::clear(void* memory, std::size_t bytes) const {
  if (bytes != 0) check_cuda(cudaMemsetAsync(memory, 0, bytes, stream()), "cudaMemsetAsync");
}

namespace {
/// `value`, an attribute of the current device, which is asked while it is 0.
int asked_once(int& value, cudaDeviceAttr attribute) {
  if (value == 0) {
    int device = 0;
    check_cuda(cudaGetDevice(&device), "cudaGetDevice");
    check_cuda(cudaDeviceGetAttribute(&value, attribute, device), "cudaDeviceGetAttribute");
  }
  return value;
}
}  // namespace

int Cuda::multiprocessors() const {
  return asked_once(state_->multiprocessors, cudaDevAttrMultiProcessorCount);
}

std::size_t Cuda::shared_memory() const {
  return std::size_t(asked_once(state_->shared_memory, cudaDevAttrMaxSharedMemoryPerBlockOptin));
}

RasterMemory& RasterMemory::of(const Cuda& cuda) { return cuda.state_->raster; }

void Cuda::settle(LastCounters<FrameCounts> counts, const Limits& limits, FrameTotals* totals) const {
  Mailbox* mailbox = nullptr;
  if (limits.report) {
    state_->raster.known_word = 0;
  } else {
    check_not_captured("settle");
    if (!state_->mailbox) state_->mailbox.reset(new (allocate_pinned(sizeof(Mailbox))) Mailbox{});
    mailbox = state_->mailbox.get();
    // If nobody took the answer before, it must not be taken for this one's.
    if (state_->awaited) state_->wait();
    std::atomic_ref<std::uint32_t>(mailbox->posted).store(0, std::memory_order_relaxed);
    state_->awaited = true;
  }
  launch_early(*this, "settle", kernels::settle, 1, 1, counts, limits, totals,
               std::as_const(state_->raster.word).data(), mailbox);
}

FrameReport Cuda::await_report() const {
  check_not_captured("await_report");
  if (!state_->awaited) throw OrderError("await_report: expected a frame to be settled before");
  Mailbox& mailbox = *state_->mailbox;
  const std::atomic_ref<std::uint32_t> posted(mailbox.posted);
  for (unsigned looks = 1; posted.load(std::memory_order_acquire) == 0; ++looks) {
    if (looks % 1024 != 0) continue;
    const cudaError_t done = cudaStreamQuery(stream());
    if (done == cudaErrorNotReady) {
      cudaGetLastError();
      std::this_thread::yield();
      continue;
    }
    check_cuda(done, "settle");
    break;
  }
  state_->awaited = false;
  state_->raster.known_word = mailbox.raster_word;
  return mailbox.report;
}

Cuda::TimePoint Cuda::now() {
  check_not_captured("now");
  auto& event = state_->events[++state_->points % state_->events.size()];
  if (!event) {
    cudaEvent_t made = nullptr;
    check_cuda(cudaEventCreate(&made), "cudaEventCreate");
    event.reset(made);
  }
  check_cuda(cudaEventRecord(event.get(), stream()), "cudaEventRecord");
  return {state_->points};
}

std::optional<double> Cuda::milliseconds(TimePoint from, TimePoint to) const {
  const auto& events = state_->events;
  if (from.serial == 0 || from.serial > to.serial || to.serial > state_->points ||
      from.serial + events.size() <= state_->points)
    return std::nullopt;
  check_not_captured("milliseconds");
  const cudaEvent_t last = events[to.serial % events.size()].get();
  const cudaError_t reached = cudaEventQuery(last);
  if (reached == cudaErrorNotReady) {
    cudaGetLastError();  // no error, but kept as one
    return std::nullopt;
  }
  check_cuda(reached, "cudaEventQuery");
  float ms = 0;
  check_cuda(cudaEventElapsedTime(&ms, events[from.serial % events.size()].get(), last),
             "cudaEventElapsedTime");
  return ms;
}

template void Cuda::for_each(Count, const ClearRanges&) const;
template void Cuda::for_each(Count, const FindRanges<std::uint16_t>&) const;
template void Cuda::for_each(Count, const FindRanges<std::uint32_t>&) const;
template void Cuda::for_each(Count, const FindRanges<std::uint64_t>&) const;

}  // namespace swiftgs
