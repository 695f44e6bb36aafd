// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <csignal>
#include <stdexcept>

namespace swiftgs::cli {

/// Ends a command that Ctrl-C has stopped; says what is left of it. The tool then ends as Ctrl-C ends others,
/// so that a script that runs it ends too.
struct Interrupted : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// While it lives, Ctrl-C does not end the program but sets `interrupted`, so that no part of a file stays
/// behind. A second Ctrl-C ends it at once. A program that was started to ignore Ctrl-C, as a shell's
/// background jobs are, still ignores it.
class Interruptible {
 public:
  Interruptible() {
    sigaction(SIGINT, nullptr, &before_);
    if (before_.sa_handler == SIG_IGN) return;
    struct sigaction noting {};
    noting.sa_handler = [](int) { interrupted_ = 1; };
    sigemptyset(&noting.sa_mask);
    // Without SA_RESTART: waiting for the other end of a pipe ends, too.
    noting.sa_flags = SA_RESETHAND;
    sigaction(SIGINT, &noting, nullptr);
  }
  ~Interruptible() { sigaction(SIGINT, &before_, nullptr); }
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;

  static bool interrupted() { return interrupted_ != 0; }
  /// Throws `Interrupted` after Ctrl-C.
  static void stop_if_interrupted() {
    if (interrupted()) throw Interrupted("cancelled");
  }

 private:
  static inline volatile std::sig_atomic_t interrupted_ = 0;
  struct sigaction before_ {};
};

}  // namespace swiftgs::cli
