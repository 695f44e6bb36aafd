// SPDX-License-Identifier: Apache-2.0
#include "ply_model.hpp"

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

}  // namespace swiftgs::io
