// SPDX-License-Identifier: Apache-2.0
#include "shell_word.hpp"

#include <cstdlib>
#include <string>

#include <doctest/doctest.h>

#include "support/files.hpp"

using swiftgs::cli::shell_word;
using swiftgs::test::content_of;
using swiftgs::test::TemporaryFolder;

TEST_CASE("shell word: a plain word stays and any other is quoted") {
  CHECK(shell_word("a/b_c.json:8=1,2@%+-") == "a/b_c.json:8=1,2@%+-");
  CHECK(shell_word("") == "''");
  CHECK(shell_word("two words") == "'two words'");
  CHECK(shell_word("it's") == "'it'\\''s'");
  CHECK(shell_word("~") == "'~'");
}

TEST_CASE("shell word: a shell gives back every character") {
  const TemporaryFolder place;
  std::string text = "'";
  for (int c = 1; c < 256; ++c) text += char(c);
  text += "''";
  const std::string command =
      "printf %s " + shell_word(text) + " >" + shell_word((place / "told.txt").string());
  REQUIRE(std::system(command.c_str()) == 0);
  CHECK(content_of(place / "told.txt") == text);
}
