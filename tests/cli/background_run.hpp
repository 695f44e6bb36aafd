// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <csignal>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support/files.hpp"

namespace swiftgs::test {

/// The tool, run in `place` while the test goes on. Its standard error is a terminal.
class BackgroundRun {
 public:
  enum class CtrlC { ends_it, is_ignored };  ///< as the tool is started

  BackgroundRun(const TemporaryFolder& place, std::vector<std::string> arguments,
                CtrlC ctrl_c = CtrlC::ends_it)
      : terminal_(::posix_openpt(O_RDWR | O_NOCTTY)) {
    REQUIRE(terminal_ >= 0);
    REQUIRE(::grantpt(terminal_) == 0);
    REQUIRE(::unlockpt(terminal_) == 0);
    const std::string name = ::ptsname(terminal_), folder = place.path().string(),
                      out = (place / "stdout.txt").string();
    arguments.insert(arguments.begin(), SWIFTGS_CLI);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    child_ = ::fork();
    REQUIRE(child_ >= 0);
    if (child_ != 0) return;
    std::signal(SIGINT, ctrl_c == CtrlC::is_ignored ? SIG_IGN : SIG_DFL);
    const int error = ::open(name.c_str(), O_RDWR | O_NOCTTY),
              output = ::open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (::chdir(folder.c_str()) == 0 && ::dup2(error, STDERR_FILENO) >= 0 &&
        ::dup2(output, STDOUT_FILENO) >= 0)
      ::execv(SWIFTGS_CLI, argv.data());
    ::_exit(127);
  }
  ~BackgroundRun() {
    if (child_ > 0) ::kill(child_, SIGKILL), ::waitpid(child_, nullptr, 0);
    ::close(terminal_);
  }
  BackgroundRun(const BackgroundRun&) = delete;
  BackgroundRun& operator=(const BackgroundRun&) = delete;

  void press_ctrl_c() const { ::kill(child_, SIGINT); }

  /// Waits until the terminal shows `text`, for a minute. Returns whether it did.
  bool shows(const std::string& text) {
    while (!contains(shown_, text))
      if (!read_terminal()) return false;
    return true;
  }

  /// Waits for the end. Returns the exit status, or -1 if the tool was killed.
  int wait() {
    while (read_terminal()) {
    }
    int status = 0;
    ::waitpid(std::exchange(child_, -1), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  /// All that the terminal was sent so far.
  const std::string& shown() const { return shown_; }

 private:
  bool read_terminal() {
    char text[4096];
    pollfd terminal{terminal_, POLLIN, 0};
    if (::poll(&terminal, 1, 60'000) <= 0) return false;
    const ssize_t count = ::read(terminal_, text, sizeof text);  // fails once the tool has ended
    if (count > 0) shown_.append(text, std::size_t(count));
    return count > 0;
  }

  int terminal_;
  pid_t child_ = -1;
  std::string shown_{};
};

}  // namespace swiftgs::test
