// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <exception>
#include <optional>
#include <thread>
#include <vector>

#include <swiftgs/mpi/direct_link.hpp>

#include "ranks_state.hpp"

namespace swiftgs {

struct Exchange::Requests {
  std::vector<MPI_Request> each;
  std::vector<DirectLink::Message> named;  ///< that `link` has not been given
  std::optional<std::uint64_t> given;      ///< what it calls those that it was
};

Exchange::Exchange(const Ranks& ranks, DirectLink* link)
    : ranks_(ranks), link_(link), requests_(std::make_unique<Requests>()) {}

Exchange::~Exchange() {
  if (std::uncaught_exceptions() != 0 && (!requests_->each.empty() || requests_->given)) {
    // Other ranks may wait for what this one will not send. The program ends, and its messages with it.
    (void)requests_.release();
    return;
  }
  try {
    wait();
  } catch (const MpiError&) {
    // There is nobody left to tell.
  }
}

namespace {

/// f(begin, bytes) for the parts of a message that are short enough.
template <class F>
void for_messages(std::size_t bytes, std::size_t longest, const F& f) {
  for (std::size_t begin = 0; begin < bytes; begin += longest) f(begin, std::min(longest, bytes - begin));
}

}  // namespace

void Exchange::send(int rank, const void* from, std::size_t bytes) {
  Ranks::State& state = ranks_.state();
  state.traffic.sent_bytes += bytes;
  if (link_) {
    if (bytes == 0) return;
    requests_->named.push_back({rank, bytes, from, nullptr});
    ++state.traffic.messages;
    return;
  }
  for_messages(bytes, state.longest_message, [&](std::size_t begin, std::size_t count) {
    MPI_Request& request = requests_->each.emplace_back(MPI_REQUEST_NULL);
    mpi::check(MPI_Isend(static_cast<const std::byte*>(from) + begin, int(count), MPI_BYTE, rank,
                         mpi::data_tag, state.comm, &request),
               "MPI_Isend");
    ++state.traffic.messages;
  });
}

void Exchange::receive(int rank, void* to, std::size_t bytes) {
  Ranks::State& state = ranks_.state();
  state.traffic.received_bytes += bytes;
  if (link_) {
    if (bytes != 0) requests_->named.push_back({rank, bytes, nullptr, to});
    return;
  }
  for_messages(bytes, state.longest_message, [&](std::size_t begin, std::size_t count) {
    MPI_Request& request = requests_->each.emplace_back(MPI_REQUEST_NULL);
    mpi::check(MPI_Irecv(static_cast<std::byte*>(to) + begin, int(count), MPI_BYTE, rank, mpi::data_tag,
                         state.comm, &request),
               "MPI_Irecv");
  });
}

void Exchange::all_to_all(const void* from, Span<const std::uint64_t> from_begins, void* to,
                          Span<const std::uint64_t> to_begins, std::size_t element_bytes) {
  const auto bytes_at = [&](Span<const std::uint64_t> begins, int r, auto* array) {
    return array + std::size_t(begins[std::size_t(r)]) * element_bytes;
  };
  const auto bytes_of = [&](Span<const std::uint64_t> begins, int r) {
    return std::size_t(begins[std::size_t(r) + 1] - begins[std::size_t(r)]) * element_bytes;
  };
  // Every rank begins with the one behind it, so that none is everybody's first.
  const int size = ranks_.size(), rank = ranks_.rank();
  for (int step = 1; step < size; ++step) {
    const int source = (rank + size - step) % size;
    receive(source, bytes_at(to_begins, source, static_cast<std::byte*>(to)), bytes_of(to_begins, source));
  }
  for (int step = 1; step < size; ++step) {
    const int target = (rank + step) % size;
    send(target, bytes_at(from_begins, target, static_cast<const std::byte*>(from)),
         bytes_of(from_begins, target));
  }
}

void Exchange::begin(void* stream) {
  if (!link_) return;
  requests_->given = link_->begin({requests_->named.data(), requests_->named.size()}, stream);
  requests_->named.clear();
}

void Exchange::join() {
  if (!link_)
    wait();
  else if (requests_->given)
    link_->order(*requests_->given);
}

bool Exchange::test() {
  if (link_) return !requests_->given || link_->test(*requests_->given);
  int done = 0;
  std::vector<MPI_Request>& each = requests_->each;
  mpi::check(MPI_Testall(int(each.size()), each.data(), &done, MPI_STATUSES_IGNORE), "MPI_Testall");
  return done != 0;
}

void Exchange::wait() {
  if (requests_->each.empty() && !requests_->given) return;
  const mpi::Waiting waiting(ranks_.state());
  if (requests_->given) {
    while (!test()) std::this_thread::yield();
    requests_->given.reset();
    return;
  }
  std::vector<MPI_Request> each;
  each.swap(requests_->each);
  mpi::check(MPI_Waitall(int(each.size()), each.data(), MPI_STATUSES_IGNORE), "MPI_Waitall");
}

}  // namespace swiftgs
