// SPDX-License-Identifier: Apache-2.0
#include "progress.hpp"

#include <cstdio>

#include <unistd.h>

namespace swiftgs::cli {

Progress::Progress(std::size_t total) : total_(total), terminal_(isatty(fileno(stderr)) != 0) {}

void Progress::start(const std::string& what) {
  if (!terminal_) return;
  constexpr std::size_t width = 24;
  const std::size_t filled = total_ ? width * done_ / total_ : 0;
  const std::string bar = std::string(filled, '#') + std::string(width - filled, '.');
  // Carriage return, text, erase to the end of the line.
  std::fprintf(stderr, "\r[%s] %zu/%zu%s %.60s\x1b[K", bar.c_str(), done_, total_, time_left().c_str(),
               what.c_str());
  std::fflush(stderr);
  shown_ = true;
}

std::string Progress::time_left() const {
  if (done_ <= begin_) return {};
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begun_;
  const auto seconds = long(elapsed.count() / double(done_ - begin_) * double(end_ - done_));
  return seconds < 60 ? ", " + std::to_string(seconds) + " s left"
                      : ", " + std::to_string(seconds / 60 + 1) + " min left";
}

void Progress::clear() {
  if (!shown_) return;
  std::fputs("\r\x1b[K", stderr);
  std::fflush(stderr);
  shown_ = false;
}

}  // namespace swiftgs::cli
