// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <csignal>

namespace swiftgs::cli {

/// While it lives, Ctrl-C does not end the program but sets `interrupted`, so that no part of a file stays
/// behind. A program that was started to ignore Ctrl-C, as a shell's background jobs are, still ignores it.
class Interruptible {
 public:
  Interruptible() {
    sigaction(SIGINT, nullptr, &before_);
    if (before_.sa_handler == SIG_IGN) return;
    struct sigaction noting {};
    noting.sa_handler = [](int) { interrupted_ = 1; };
    sigemptyset(&noting.sa_mask);
    // Without SA_RESTART: waiting for the other end of a pipe ends, too.
    sigaction(SIGINT, &noting, nullptr);
  }
  ~Interruptible() { sigaction(SIGINT, &before_, nullptr); }
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;

  static bool interrupted() { return interrupted_ != 0; }

 private:
  static inline volatile std::sig_atomic_t interrupted_ = 0;
  struct sigaction before_ {};
};

}  // namespace swiftgs::cli
