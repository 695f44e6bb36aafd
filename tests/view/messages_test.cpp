// SPDX-License-Identifier: Apache-2.0
#include "view/messages.hpp"

#include <string>

#include <doctest/doctest.h>

using swiftgs::cli::Messages;

namespace {

std::string texts(const Messages& messages) {
  std::string all;
  for (const Messages::Message& message : messages.all()) all += message.text + ";";
  return all;
}

}  // namespace

TEST_CASE("view messages: notes leave after seconds or at the next action and errors stay") {
  Messages messages;
  messages.error("broken.ply", 10), messages.note("wrote a", 10), messages.note("wrote b", 12);
  CHECK(texts(messages) == "broken.ply;wrote a;wrote b;");
  messages.expire(10 + Messages::seconds_of_note - 0.1);
  CHECK(texts(messages) == "broken.ply;wrote a;wrote b;");
  messages.expire(10 + Messages::seconds_of_note);
  CHECK(texts(messages) == "broken.ply;wrote b;");
  messages.act();
  CHECK(texts(messages) == "broken.ply;");
  messages.expire(1e9);
  CHECK(texts(messages) == "broken.ply;");
}

TEST_CASE("view messages: errors are told once and dismissed one by one") {
  Messages messages;
  messages.dismiss_last();
  messages.error("a", 0), messages.error("b", 1), messages.error("a", 2), messages.error("c", 3);
  CHECK(texts(messages) == "b;a;c;");
  messages.dismiss(0);
  CHECK(texts(messages) == "a;c;");
  messages.dismiss_last();
  CHECK(texts(messages) == "a;");
}
