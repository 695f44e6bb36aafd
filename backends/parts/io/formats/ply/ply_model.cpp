// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include <swiftgs/error.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "ply_fields.hpp"
#include "text.hpp"

namespace swiftgs::io {

namespace {

std::string in_small_letters(std::string_view text) {
  std::string small(text);
  for (char& c : small)
    if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
  return small;
}

constexpr std::string_view own_key = "renderingmodel:";

}  // namespace

RenderingModel model_of(const PlyHeader& header, bool filtered, std::vector<std::string>& notes) {
  RenderingModel model;
  // The variance that Mip-Splatting's trainer and renderer add.
  if (filtered) model.blur = 0.1f, model.antialiased = true;
  for (const std::string& comment : header.comments) {
    Tokens tokens(comment);
    const std::string key = in_small_letters(tokens.next()), value = in_small_letters(tokens.next());
    if (key == "splatrendermode:" || key == "splatrendermode") {
      model.antialiased = value == "mip";
      model.kernel = value == "2dgs" ? RenderingModel::Kernel::disk : RenderingModel::Kernel::ellipsoid;
    } else if (key == "antialiased" && (value == "0" || value == "1")) {
      model.antialiased = value == "1";
    } else if (key == own_key) {
      try {
        model = model_from(value, model);
      } catch (const InvalidArgument&) {  // no comment makes a file unreadable
        notes.push_back("The comment on the rendering model is not known, and ignored: " + value + ".");
      }
    }
  }
  return model;
}

std::string model_comments(const RenderingModel& model) {
  std::string comments;
  RenderingModel told;
  if (model.antialiased)
    comments += "comment SplatRenderMode: mip\n", told.antialiased = true;
  else if (model.kernel == RenderingModel::Kernel::disk)
    comments += "comment SplatRenderMode: 2dgs\n", told.kernel = model.kernel;
  if (model != told) comments += "comment RenderingModel: " + text_of(model) + "\n";
  return comments;
}

std::vector<std::string> notes_of(bool unused_scale, const PlySh& sh) {
  std::vector<std::string> notes;
  if (unused_scale) notes.push_back("The third scale of the Gaussians, which are flat, is not used.");
  if (sh.stored_degree > sh.degree)
    notes.push_back("SH coefficients of degree 4 are stored; degree 3 and below are kept.");
  return notes;
}

void note_unread(const PlyHeader& header, const std::vector<std::string_view>& read,
                 const std::vector<std::string>& unread, std::vector<std::string>& notes) {
  if (!unread.empty())
    notes.push_back("Properties that a scene does not have were not read: " + listed(unread) + ".");
  std::vector<std::string> elements;
  for (const PlyElement& element : header.elements)
    if (element.count > 0 && std::find(read.begin(), read.end(), element.name) == read.end())
      elements.push_back(element.name);
  if (!elements.empty())
    notes.push_back("Elements other than Gaussians were not read: " + listed(elements) + ".");
}

}  // namespace swiftgs::io
