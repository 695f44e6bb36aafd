// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>

#include <doctest/doctest.h>

#include <swiftgs/error.hpp>

namespace swiftgs::test::message_test {

using detail::message, detail::refuse;

TEST_CASE("message: parts stand one behind the other as std::to_string writes them") {
  CHECK(message("") == "");
  CHECK(message("a", std::string("b"), std::string_view("cd").substr(1)) == "abd");
  CHECK(message(std::numeric_limits<std::int64_t>::min(), " ", std::numeric_limits<std::uint64_t>::max()) ==
        "-9223372036854775808 18446744073709551615");
  CHECK(message((unsigned char)(200), ", ", (signed char)(-3), ", ", std::int16_t(-300)) == "200, -3, -300");
  CHECK(message(0.5f, " ", -1e-7, " ", std::numeric_limits<double>::infinity()) == "0.500000 -0.000000 inf");
  CHECK(message(std::numeric_limits<float>::quiet_NaN()) == "nan");
}

TEST_CASE("message: what is refused is an invalid argument") {
  CHECK_THROWS_WITH_AS(refuse("scene: ", 7, " is wrong"), "scene: 7 is wrong", std::invalid_argument);
}

}  // namespace swiftgs::test::message_test
