// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdlib>
#include <initializer_list>
#include <regex>
#include <sstream>
#include <string>

#include <doctest/doctest.h>
#include <sys/wait.h>

#include "support/files.hpp"

namespace swiftgs::test {

inline std::ptrdiff_t lines_in(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

/// Checks that `text` holds all `parts`.
inline void check_holds(const std::string& text, std::initializer_list<std::string> parts) {
  CAPTURE(text);
  for (const std::string& part : parts) {
    CAPTURE(part);
    CHECK(contains(text, part));
  }
}

/// What a command said and how it ended.
struct Outcome {
  int code = -1;         ///< -1 if it was killed
  std::string out, err;  ///< `err` without lines of progress, which slow machines see
};

inline std::string without_progress(const std::string& text) {
  std::istringstream in(text);
  std::string rest;
  for (std::string line; std::getline(in, line);)
    if (!std::regex_search(line, std::regex(R"(^\[\d+/\d+)"))) rest += line + "\n";
  return rest;
}

/// Runs the tool in `place` after `first`, a command that may set limits; `arguments` are a shell's.
inline Outcome run_after(const TemporaryFolder& place, const std::string& first,
                         const std::string& arguments) {
  const std::string out = (place / "stdout.txt").string(), err = (place / "stderr.txt").string();
  const int status = std::system(("cd '" + place.path().string() + "' && " + first +
                                  " && '" SWIFTGS_CLI "' " + arguments + " >'" + out + "' 2>'" + err + "'")
                                     .c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, content_of(out), without_progress(content_of(err))};
}

/// Runs the tool in `place`; `arguments` are a shell's.
inline Outcome swiftgs(const TemporaryFolder& place, const std::string& arguments) {
  return run_after(place, "true", arguments);
}

/// The same, of a command that must end well. It may say notes of its files.
inline Outcome run_noting(const TemporaryFolder& place, const std::string& arguments) {
  Outcome outcome = swiftgs(place, arguments);
  CAPTURE(arguments);
  CAPTURE(outcome.err);
  CHECK(outcome.code == 0);
  return outcome;
}

/// The same, of one that must say nothing on standard error.
inline Outcome run(const TemporaryFolder& place, const std::string& arguments) {
  Outcome outcome = run_noting(place, arguments);
  CAPTURE(arguments);
  CHECK(outcome.err == "");
  return outcome;
}

/// Runs the tool and expects exit code 1 and one line on standard error, which it returns.
inline std::string refusal(const TemporaryFolder& place, const std::string& arguments) {
  const Outcome outcome = swiftgs(place, arguments);
  CAPTURE(arguments);
  CAPTURE(outcome.err);
  CHECK(outcome.code == 1);
  CHECK(lines_in(outcome.err) == 1);
  CHECK(outcome.err.starts_with("swiftgs: "));
  return outcome.err;
}

/// The same of a line that holds all `parts`.
inline void fails(const TemporaryFolder& place, const std::string& arguments,
                  std::initializer_list<std::string> parts) {
  CAPTURE(arguments);
  check_holds(refusal(place, arguments), parts);
}

}  // namespace swiftgs::test
