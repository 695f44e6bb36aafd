# SPDX-License-Identifier: Apache-2.0

# Linked privately by every target that is compiled here; never by a user's.
add_library(swiftgs_warnings INTERFACE)
target_compile_options(swiftgs_warnings INTERFACE
  # Sign conversions are left out: indices are int or size_t by meaning, and the casts would hide the arithmetic.
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
  $<$<BOOL:${SWIFTGS_WARNINGS_AS_ERRORS}>:-Werror>)
