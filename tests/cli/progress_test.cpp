// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cstdio>
#include <string>

#include <doctest/doctest.h>
#include <fcntl.h>
#include <unistd.h>

#include "notes.hpp"
#include "support/files.hpp"

using namespace swiftgs::test;
using swiftgs::cli::Progress;
using namespace std::chrono_literals;

namespace {

/// What `work` writes on standard error, which is a file meanwhile.
template <class Work>
std::string said_by(const Work& work) {
  const TemporaryFolder place;
  const std::string file = (place / "stderr.txt").string();
  std::fflush(stderr);
  const int before = ::dup(STDERR_FILENO), said = ::open(file.c_str(), O_WRONLY | O_CREAT, 0600);
  ::dup2(said, STDERR_FILENO);
  work();
  std::fflush(stderr);
  ::dup2(before, STDERR_FILENO);
  ::close(before), ::close(said);
  return content_of(file);
}

}  // namespace

TEST_CASE("cli progress: without a terminal a line now and then says what is done and left") {
  CHECK(said_by([] {
          Progress progress(100, 0ms);
          progress.start("first");
          progress.advance_to(40);
          progress.begin_part(100);
          progress.start("second");
          progress.step();
          progress.start("third");
          progress.clear();
        }) == "[0/100] first\n[40/100] second\n[41/100, 0 s left] third\n");
}

TEST_CASE("cli progress: lines are apart and a short command says nothing") {
  CHECK(said_by([] {
          Progress progress(1000, 1h);
          for (int i = 0; i < 1000; ++i) progress.start("a row"), progress.step();
        }) == "");
}
