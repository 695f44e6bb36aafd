// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace swiftgs::test {

/// Reports the running test as skipped, not passed; call it once and return from the test.
/// A check that failed before still fails the test.
void skip(const std::string& reason);

}  // namespace swiftgs::test
