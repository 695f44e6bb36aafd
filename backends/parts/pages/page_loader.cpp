// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <condition_variable>
#include <exception>
#include <iterator>
#include <list>
#include <mutex>
#include <new>
#include <set>
#include <utility>

#include <swiftgs/error.hpp>
#include <swiftgs/pages/page_loader.hpp>

namespace swiftgs::detail {

struct PageLoader::State {
  std::vector<PagedScene> files;
  std::size_t most_bytes = 0;

  std::mutex mutex;
  std::condition_variable asked, read;
  std::vector<PageKey> queue;    ///< the first comes last
  std::vector<PageKey> reading;  ///< has room for all readers
  std::list<LoadedPage> loaded;
  std::size_t loaded_bytes = 0, kept_bytes = 0;
  std::size_t jobs = 0;  ///< that an executor has
  bool stop = false;
  PageUpload upload;
  std::mutex uploads;  ///< held while `upload` runs

  bool can_read() const { return !queue.empty() && loaded_bytes + kept_bytes < most_bytes; }

  void load(LoadedPage& page) {
    try {
      page.content = files[page.key.file].read(page.key.page);
      if (upload) {
        const std::lock_guard one(uploads);
        page.uploaded = upload(std::move(page.content.scene));
      }
    } catch (const std::exception& error) {
      page.failure = *error.what() != '\0' ? error.what() : "a source threw an exception without a text";
    } catch (...) {
      page.failure = "a source threw what is no exception of the standard library";
    }
  }

  /// Reads the first page of the queue, if there is room for it. `lock` is open meanwhile.
  void read_next(std::unique_lock<std::mutex>& lock) {
    if (stop || !can_read()) return;
    const PageKey key = queue.back();
    queue.pop_back(), reading.push_back(key);
    lock.unlock();
    std::list<LoadedPage> page;
    try {
      load(page.emplace_back(LoadedPage{key, {}}));
    } catch (const std::bad_alloc&) {
      page.clear();  // not loaded: who needs it asks again
    }
    lock.lock();
    reading.erase(std::find(reading.begin(), reading.end(), key));
    if (!page.empty() && page.front().failure.empty())
      loaded_bytes += files[key.file].pages()[key.page].bytes;
    loaded.splice(loaded.end(), page);
    read.notify_all();
  }

  void read_until_stopped() {
    std::unique_lock lock(mutex);
    for (;;) {
      asked.wait(lock, [&] { return stop || can_read(); });
      if (stop) return;
      read_next(lock);
    }
  }
};

PageLoader::PageLoader(std::vector<PagedScene> files, std::size_t most_bytes, int threads,
                       PageExecutor executor, PageUpload upload)
    : state_(std::make_shared<State>()), executor_(std::move(executor)) {
  state_->upload = std::move(upload);
  state_->files = std::move(files), state_->most_bytes = std::max<std::size_t>(most_bytes, 1);
  if (threads < 1) refuse("page pool: ", threads, " threads, expected 1 or more");
  state_->reading.reserve(executor_ ? most_jobs : std::size_t(threads));
  if (executor_) return;
  try {
    for (int k = 0; k < threads; ++k)
      threads_.emplace_back([state = state_] { state->read_until_stopped(); });
  } catch (...) {
    stop();
    throw;
  }
}

PageLoader::~PageLoader() { stop(); }

void PageLoader::stop() {
  {
    std::unique_lock lock(state_->mutex);
    state_->stop = true;
    state_->asked.notify_all();
    // What `upload` made may need the uploader, which the caller destroys next.
    state_->read.wait(lock, [&] { return state_->reading.empty(); });
    state_->queue.clear(), state_->loaded.clear();
  }
  for (std::thread& thread : threads_) thread.join();
}

void PageLoader::request(const std::vector<PageKey>& keys) {
  std::size_t jobs = 0;
  std::vector<PageKey> queue;
  std::set<PageKey> known;  ///< few: nobody reads while `queue` is being made
  {
    const std::lock_guard lock(state_->mutex);
    queue.swap(state_->queue);
    known.insert(state_->reading.begin(), state_->reading.end());
    for (const LoadedPage& page : state_->loaded) known.insert(page.key);
  }
  queue.clear();
  std::copy_if(keys.rbegin(), keys.rend(), std::back_inserter(queue),
               [&](const PageKey& key) { return !known.contains(key); });
  {
    const std::lock_guard lock(state_->mutex);
    state_->queue.swap(queue);
    if (executor_ && state_->can_read() && state_->jobs < most_jobs)
      jobs = std::min(most_jobs - state_->jobs, state_->queue.size());
    state_->jobs += jobs;
  }
  state_->asked.notify_all();
  const auto job = [state = state_] {
    std::unique_lock lock(state->mutex);
    state->read_next(lock);
    --state->jobs;
    state->read.notify_all();
  };
  try {
    for (; jobs != 0; --jobs) executor_(job);
  } catch (...) {
    const std::lock_guard lock(state_->mutex);
    state_->jobs -= jobs;  // which nobody runs
    throw;
  }
}

std::list<LoadedPage> PageLoader::take() {
  std::list<LoadedPage> loaded;
  {
    const std::lock_guard lock(state_->mutex);
    loaded.swap(state_->loaded);
    state_->kept_bytes += std::exchange(state_->loaded_bytes, 0);
  }
  return loaded;
}

void PageLoader::keep(std::size_t bytes) {
  const std::lock_guard lock(state_->mutex);
  state_->kept_bytes = bytes;  // `request` follows and tells the thread
}

void PageLoader::wait() {
  std::unique_lock lock(state_->mutex);
  state_->read.wait(lock, [&] {
    const bool busy =
        !state_->reading.empty() || state_->jobs != 0 || (!threads_.empty() && state_->can_read());
    return !state_->loaded.empty() || !busy;
  });
}

}  // namespace swiftgs::detail
