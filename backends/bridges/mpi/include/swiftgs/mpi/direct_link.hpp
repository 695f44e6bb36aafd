// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/mpi/ranks.hpp>

namespace swiftgs {

/// Carries arrays from backend to backend without the host, in place of MPI. All ranks give it messages in
/// one order; both ends name each message.
///
/// Its functions throw `MpiError`. Other ranks may then wait for this one.
class SWIFTGS_API DirectLink {
 public:
  struct Message {
    int rank = 0;  ///< the other end
    std::size_t bytes = 0;
    const void* from = nullptr;  ///< in memory of the backend; null for what is received
    void* to = nullptr;          ///< null for what is sent
  };

  virtual ~DirectLink() = default;

  virtual std::string_view name() const = 0;

  /// Begins messages behind all work submitted so far to the backend, or to `stream` of its device if that is
  /// not null (`Shading::stream`). Does not wait. Returns the number by which `order` and `test` know them.
  virtual std::uint64_t begin(Span<const Message> messages, void* stream) = 0;

  /// Orders later work of the backend behind these messages.
  virtual void order(std::uint64_t begun) = 0;

  /// Whether these messages have been sent and received.
  virtual bool test(std::uint64_t begun) = 0;
};

/// The link between the backends of all ranks, null where messages go by the host: on all ranks alike.
/// Collective. A backend that has one overloads this.
template <BackendPolicy B>
std::unique_ptr<DirectLink> direct_link(const Ranks&, B&) {
  return nullptr;
}

}  // namespace swiftgs
