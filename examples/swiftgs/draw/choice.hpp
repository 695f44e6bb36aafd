// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/any_renderer.hpp>

namespace swiftgs::cli {

/// The renderers that can run here and match one of `patterns`, which commas separate, as file names match a
/// shell's. Throws
/// `InvalidArgument` with an example of a valid name if one of them matches none.
std::vector<RendererEntry> renderers_matching(const std::string& patterns);

/// The renderer on `backend` with no approximation beyond float and every tile list exact.
std::string exact_renderer(std::string_view backend);

/// The renderer that `render` uses unless told otherwise: the exact one on the first backend of `cpu` and
/// `serial` that can run here. Throws `Unavailable` where neither can.
std::string default_renderer();

}  // namespace swiftgs::cli
