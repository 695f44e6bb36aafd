// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the libraries export. They are compiled with hidden symbols, so that theirs meet no other library's;
/// what is not inline and has this mark can be called from outside of a shared one. Types have it where their
/// type information crosses the border, as exceptions' does, or where a function that is exported is a template
/// of them.

#if defined(__GNUC__)
#define SWIFTGS_API __attribute__((visibility("default")))
#else
#define SWIFTGS_API
#endif
