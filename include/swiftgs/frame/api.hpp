// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Marks the symbols that shared libraries export. All other symbols are hidden, so that they cannot clash
/// with another library's. Functions that are not inline need the mark to be called from outside. Types need
/// it if their type information crosses the border, as that of exceptions does, or if an exported function is
/// a template of them.

#if defined(__GNUC__)
#define SWIFTGS_API __attribute__((visibility("default")))
#else
#define SWIFTGS_API
#endif
