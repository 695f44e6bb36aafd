// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <condition_variable>
#include <exception>
#include <list>
#include <mutex>
#include <utility>

#include <swiftgs/error.hpp>
#include <swiftgs/pages/page_loader.hpp>

namespace swiftgs::detail {

struct PageLoader::State {
  std::vector<PagedScene> files;
  std::size_t most_bytes = 0;

  std::mutex mutex;
  std::condition_variable asked, read;
  std::list<LoadedPage> queue, reading, loaded;  ///< a page moves on, so that readers allocate no node
  std::size_t loaded_bytes = 0, kept_bytes = 0;
  std::size_t jobs = 0;  ///< that an executor has
  bool stop = false;
  PageUpload upload;
  std::mutex uploads;  ///< held while `upload` runs

  bool can_read() const { return !queue.empty() && loaded_bytes + kept_bytes < most_bytes; }

  /// Reads the first page of the queue, if there is room for it. `lock` is open meanwhile.
  void read_next(std::unique_lock<std::mutex>& lock) {
    if (stop || !can_read()) return;
    const auto at = queue.begin();
    LoadedPage& page = *at;
    reading.splice(reading.end(), queue, at);
    lock.unlock();
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
    lock.lock();
    loaded.splice(loaded.end(), reading, at);
    if (page.failure.empty()) loaded_bytes += files[page.key.file].pages()[page.key.page].bytes;
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
  {
    const std::lock_guard lock(state_->mutex);
    state_->queue.clear();
    const auto is_known = [&](const PageKey& key) {
      const auto has_key = [&](const LoadedPage& page) { return page.key == key; };
      return std::any_of(state_->reading.begin(), state_->reading.end(), has_key) ||
             std::any_of(state_->loaded.begin(), state_->loaded.end(), has_key);
    };
    for (const PageKey& key : keys)
      if (!is_known(key)) state_->queue.push_back({key, {}});
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
