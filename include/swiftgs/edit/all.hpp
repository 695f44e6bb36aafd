// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Scenes edited on the host: moved, cut, joined and put in another order.

#include <swiftgs/edit/order.hpp>
#include <swiftgs/edit/origin.hpp>
#include <swiftgs/edit/select.hpp>
#include <swiftgs/edit/transform.hpp>
