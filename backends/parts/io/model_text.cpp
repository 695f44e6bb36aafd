// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cstddef>
#include <iterator>
#include <string>
#include <string_view>
#include <system_error>

#include <swiftgs/error.hpp>
#include <swiftgs/io/scene_file.hpp>

namespace swiftgs {
namespace {

constexpr const char* names_of_switch[] = {"no", "yes"};
constexpr const char* names_of_order[] = {"depth", "distance"};
constexpr const char* names_of_colours[] = {"srgb", "linear"};
constexpr const char* names_of_kernel[] = {"ellipsoid", "disk"};

/// Sets `to` to what `value` names; false if it names nothing.
template <class T>
bool choose(std::string_view value, const char* const (&names)[2], T& to) {
  for (int i = 0; i < 2; ++i)
    if (value == names[i]) return to = T(i), true;
  return false;
}

float blur_from(std::string_view value) {
  float blur = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), blur);
  if (error != std::errc() || end != value.data() + value.size() || !detail::is_blur(blur))
    detail::refuse("model: the blur is '", value, "', expected a number of 0 or more, in pixels^2");
  return blur;
}

void set(RenderingModel& model, std::string_view setting) {
  const std::size_t at = setting.find('=');
  const std::string_view key = setting.substr(0, at);
  const std::string_view value = at == setting.npos ? std::string_view() : setting.substr(at + 1);
  if (key == "blur" && at != setting.npos) {
    model.blur = blur_from(value);
    return;
  }
  const bool known = (key == "antialiased" && choose(value, names_of_switch, model.antialiased)) ||
                     (key == "order" && choose(value, names_of_order, model.order)) ||
                     (key == "colours" && choose(value, names_of_colours, model.colours)) ||
                     (key == "kernel" && choose(value, names_of_kernel, model.kernel));
  if (!known)
    detail::refuse("model: '", setting, "' is not known; expected antialiased=yes or no, blur=NUMBER, ",
                   "order=depth or distance, colours=srgb or linear, kernel=ellipsoid or disk");
}

}  // namespace

std::string text_of(const RenderingModel& model) {
  const RenderingModel usual;
  std::string text;
  const auto add = [&](std::string_view key, std::string_view value) {
    text.append(text.empty() ? "" : ",").append(key).append("=").append(value);
  };
  if (model.blur != usual.blur) {
    char digits[64];
    const auto end = std::to_chars(digits, std::end(digits), model.blur).ptr;
    add("blur", std::string_view(digits, std::size_t(end - digits)));
  }
  if (model.antialiased != usual.antialiased) add("antialiased", names_of_switch[model.antialiased]);
  if (model.order != usual.order) add("order", names_of_order[int(model.order)]);
  if (model.colours != usual.colours) add("colours", names_of_colours[int(model.colours)]);
  if (model.kernel != usual.kernel) add("kernel", names_of_kernel[int(model.kernel)]);
  return text;
}

RenderingModel model_from(std::string_view text, RenderingModel model) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(','), text.size());
    set(model, text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return model;
}

}  // namespace swiftgs
