// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace swiftgs::cli {

/// What the viewer tells the user. Notes leave after some seconds or at the next action. Errors stay until
/// the user dismisses them. Times are in seconds, and only differences of them count.
class Messages {
 public:
  static constexpr double seconds_of_note = 5;

  struct Message {
    std::string text;
    bool is_error = false;
    double since = 0;
  };

  void note(std::string text, double now) { add({std::move(text), false, now}); }
  /// An error that is there already is not repeated.
  void error(std::string text, double now) { add({std::move(text), true, now}); }

  /// The user did something: notes were read.
  void act() {
    std::erase_if(all_, [](const Message& message) { return !message.is_error; });
  }
  void expire(double now) {
    std::erase_if(all_, [now](const Message& message) {
      return !message.is_error && now - message.since >= seconds_of_note;
    });
  }
  void dismiss(std::size_t number) { all_.erase(all_.begin() + std::ptrdiff_t(number)); }
  /// Dismisses the last message, if there is one.
  void dismiss_last() {
    if (!all_.empty()) all_.pop_back();
  }

  /// The oldest first.
  const std::vector<Message>& all() const { return all_; }

 private:
  void add(Message message) {
    std::erase_if(all_, [&](const Message& old) { return old.text == message.text; });
    all_.push_back(std::move(message));
  }

  std::vector<Message> all_;
};

}  // namespace swiftgs::cli
