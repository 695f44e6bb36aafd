// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/pages/paged_scene.hpp>

namespace swiftgs {

/// Runs a function once, at any time, in a thread that does not call `PagePool::wait`. It drops none, unless
/// it throws.
using PageExecutor = std::function<void(std::function<void()> load)>;

}  // namespace swiftgs

namespace swiftgs::detail {

/// Jobs that an executor has at once.
inline constexpr std::size_t most_jobs = 8;

/// A page of a file.
struct PageKey {
  std::uint32_t file = 0, page = 0;
  auto operator<=>(const PageKey&) const = default;
};

/// A page that was read, or why it was not.
struct LoadedPage {
  PageKey key;
  PageContent content;
  std::shared_ptr<void> uploaded{};  ///< in place of the scene of `content`, where threads upload
  std::string failure{};             ///< empty if it was read
};

/// Uploads the scene of a page that was read. One thread at a time calls it.
using PageUpload = std::function<std::shared_ptr<void>(Scene scene)>;

/// Reads pages in threads of its own or by an executor. No function blocks but `wait` and the destructor,
/// which waits for the pages that are being read: the others hold the lock while numbers of pages that are
/// being read or were read are copied. Jobs that an executor runs later do nothing.
class SWIFTGS_API PageLoader {
 public:
  /// Uploads pages by `upload` if there is one. Stops reading while read pages, `keep`'s bytes included, take
  /// `most_bytes` or more.
  PageLoader(std::vector<PagedScene> files, std::size_t most_bytes, int threads, PageExecutor executor,
             PageUpload upload = {});
  ~PageLoader();
  PageLoader(const PageLoader&) = delete;
  PageLoader& operator=(const PageLoader&) = delete;

  /// Replaces the list of pages to read. The first is read first.
  void request(const std::vector<PageKey>& keys);
  /// Pages read since the last call.
  std::list<LoadedPage> take();
  /// Sets the bytes of taken pages that are not uploaded yet.
  void keep(std::size_t bytes);
  /// Returns when there is something to take, or nothing is being read or asked for.
  void wait();

 private:
  /// Returns when no thread and no job reads.
  void stop();

  struct State;
  std::shared_ptr<State> state_;  ///< jobs of an executor may outlive the loader
  PageExecutor executor_;
  std::vector<std::thread> threads_;
};

}  // namespace swiftgs::detail
