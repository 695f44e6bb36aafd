// SPDX-License-Identifier: Apache-2.0
#define DOCTEST_CONFIG_IMPLEMENT
#include <iostream>

#include <doctest/doctest.h>

#include "support/skip.hpp"

namespace swiftgs::test {
namespace {

constexpr int exit_skipped = 77;  // SKIP_RETURN_CODE of every test
unsigned tests_run = 0;
unsigned tests_skipped = 0;
bool skipped = false;  // the test that runs, which may say so several times

/// Counts what ran: doctest calls a run in which no test matched the filter a success.
struct Counter : doctest::IReporter {
  explicit Counter(const doctest::ContextOptions&) {}
  void test_run_end(const doctest::TestRunStats& stats) override {
    tests_run = stats.numTestCasesPassingFilters;
  }
  void report_query(const doctest::QueryData&) override {}
  void test_run_start() override {}
  void test_case_start(const doctest::TestCaseData&) override { skipped = false; }
  void test_case_reenter(const doctest::TestCaseData&) override {}
  void test_case_end(const doctest::CurrentTestCaseStats&) override { tests_skipped += skipped; }
  void test_case_exception(const doctest::TestCaseException&) override {}
  void subcase_start(const doctest::SubcaseSignature&) override {}
  void subcase_end() override {}
  void log_assert(const doctest::AssertData&) override {}
  void log_message(const doctest::MessageData&) override {}
  void test_case_skipped(const doctest::TestCaseData&) override {}
};
DOCTEST_REGISTER_LISTENER("counter", 1, Counter);

}  // namespace

void skip(const std::string& reason) {
  skipped = true;
  MESSAGE("skipped: ", reason);
}

}  // namespace swiftgs::test

int main(int argc, char** argv) {
  using namespace swiftgs::test;
  doctest::Context context(argc, argv);
  const int result = context.run();
  if (context.shouldExit() || result != 0) return result;
  if (tests_run == 0) {
    std::cerr << "no test case matched; a name may hold neither a comma nor a semicolon\n";
    return 1;
  }
  return tests_skipped == tests_run ? exit_skipped : 0;
}
