// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <string>

namespace swiftgs::cli {

/// A number as the user may have typed it, for messages.
inline std::string text_of_number(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", number);
  return text;
}

}  // namespace swiftgs::cli
