// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/mpi/ranks.hpp>
#include <swiftgs/mpi/shares.hpp>

namespace swiftgs {

/// What a rank tells another before splats.
struct Offer {
  std::uint64_t splats = 0;  ///< for the rank that reads this
  std::uint32_t failed = 0;
  std::uint32_t gaussians = 0;  ///< of the rank's part; 0 if no view asks for indices
  std::uint64_t frame = 0;      ///< identity of the frame that was asked for
};

/// Tells each rank `mine`, and how many splats come. Sets `from` to what each tells this one. Throws on all
/// ranks if one failed, or if ranks were asked for different frames. Collective.
template <class B>
void exchange_offers(const Ranks& all, const Shares<B>& shares, Offer mine, Failure& failure,
                     std::vector<Offer>& from) {
  const auto ranks = std::size_t(all.size()), own = std::size_t(all.rank());
  mine.failed = bool(failure);
  std::vector<Offer> to(ranks, mine);
  from.assign(ranks, {});
  std::vector<std::uint64_t> begins_of_all(ranks + 1);
  for (std::size_t r = 0; r < ranks; ++r) {
    if (!failure) to[r].splats = shares.count_for(int(r));
    begins_of_all[r + 1] = r + 1;
  }
  const Span<const std::uint64_t> begins{begins_of_all.data(), begins_of_all.size()};
  Exchange exchange(all);
  exchange.all_to_all(to.data(), begins, from.data(), begins, sizeof(Offer));
  exchange.wait();
  from[own] = to[own];
  bool well = true;
  for (std::size_t r = 0; r < ranks; ++r) {
    well = well && from[r].failed == 0 && from[r].frame == mine.frame;
    if (from[r].frame != from[0].frame)
      failure.guard([&] {
        detail::refuse("render: the views of rank ", r,
                       " differ from those of rank 0, expected the same on all ranks");
      });
  }
  if (!well) failure.tell(all);
}

}  // namespace swiftgs
