// SPDX-License-Identifier: Apache-2.0

#include "notes.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include <unistd.h>

#include "draw/team.hpp"

namespace swiftgs::cli {

std::vector<std::string> notes_of(const std::string& file, const std::vector<std::string>& notes) {
  std::vector<std::string> named;
  for (const std::string& note : notes) named.push_back(file + ": " + note);
  return named;
}

void say_notes(const std::string& file, const std::vector<std::string>& notes,
               std::vector<std::string>& said) {
  for (std::string& line : notes_of(file, notes)) {
    if (std::find(said.begin(), said.end(), line) != said.end()) continue;
    said.push_back(std::move(line));
    if (Team::here().leads()) std::fprintf(stderr, "swiftgs: %s\n", said.back().c_str());
  }
}

namespace {

/// Whether the bar ends up on a terminal. A launcher that runs here passes on what it reads from a pipe.
bool ends_on_terminal() {
  if (isatty(fileno(stderr))) return true;
  if (!Team::here().is_shared()) return false;
  std::error_code unknown;
  const std::filesystem::path launchers =
      std::filesystem::read_symlink("/proc/" + std::to_string(getppid()) + "/fd/2", unknown);
  return launchers.string().starts_with("/dev/pts/") || launchers.string().starts_with("/dev/tty");
}

}  // namespace

Progress::Progress(std::size_t total, std::chrono::milliseconds between_lines)
    : total_(total),
      leads_(Team::here().leads()),
      terminal_(leads_ && ends_on_terminal()),
      between_lines_(between_lines) {}

void Progress::step() {
  if (leads_)
    ++done_;
  else
    Team::here().tell_step();
}

void Progress::await_others() {
  Team::here().meet([&] { start("in other processes"); });
}

void Progress::start(const std::string& what) {
  if (!leads_) return;
  done_ += Team::here().steps_told();
  if (terminal_)
    draw_bar(what);
  else if (Clock::now() - last_line_ >= between_lines_)
    print_line(what);
}

void Progress::draw_bar(const std::string& what) {
  constexpr std::size_t width = 24;
  const std::size_t filled = total_ ? width * done_ / total_ : 0;
  const std::string bar = std::string(filled, '#') + std::string(width - filled, '.');
  // Carriage return, text, erase to the end of the line.
  std::fprintf(stderr, "\r[%s] %zu/%zu%s %.60s\x1b[K", bar.c_str(), done_, total_, time_left().c_str(),
               what.c_str());
  std::fflush(stderr);
  shown_ = true;
}

void Progress::print_line(const std::string& what) {
  std::fprintf(stderr, "[%zu/%zu%s] %s\n", done_, total_, time_left().c_str(), what.c_str());
  last_line_ = Clock::now();
}

std::string Progress::time_left() const {
  if (done_ <= begin_) return {};
  const std::chrono::duration<double> elapsed = Clock::now() - begun_;
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
