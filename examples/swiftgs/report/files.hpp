// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace swiftgs::cli {

/// Everything a file holds. Throws std::system_error with its name.
std::string content_of_file(const std::string& name);

/// An image as a URI that holds it. Throws std::invalid_argument where it is neither PNG nor JPEG, in the
/// name of `wanted_by`, the file that names it; std::system_error where it cannot be read.
std::string data_uri_of_image(const std::string& name, const std::string& wanted_by);

}  // namespace swiftgs::cli
