// SPDX-License-Identifier: Apache-2.0
#include "ply_model.hpp"

#include <algorithm>

#include "listed.hpp"
#include "tokens.hpp"

namespace swiftgs::io {

PlyModel model_of(const PlyHeader& header) {
  PlyModel model;
  for (const std::string& comment : header.comments) {
    Tokens tokens(comment);
    const std::string_view key = tokens.next(), value = tokens.next();
    if (key == "SplatRenderMode:")
      model = {.antialiased = value == "mip", .flat = value == "2dgs"};
    else if (key == "antialiased" && (value == "0" || value == "1"))
      model.antialiased = value == "1";
  }
  return model;
}

std::vector<std::string> notes_of(bool flat, bool unused_scale, const PlySh& sh) {
  std::vector<std::string> notes;
  if (flat)
    notes.push_back("The Gaussians were trained as 2D ones; they are kept as flat 3D ones" +
                    std::string(unused_scale ? ", and the third scale is not used." : "."));
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
