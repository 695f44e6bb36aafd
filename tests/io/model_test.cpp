// SPDX-License-Identifier: Apache-2.0

// Rendering models as text, and in files.
#include <stdexcept>
#include <string>
#include <utility>

#include <swiftgs/io/model_text.hpp>

#include "ply_text.hpp"
#include "scenes.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

const RenderingModel all{.blur = 0.1f,
                         .antialiased = true,
                         .order = SplatOrder::distance,
                         .colours = ColourSpace::linear,
                         .kernel = RenderingModel::Kernel::disk};

}  // namespace

TEST_CASE("model text: what is not usual is written, and read back") {
  CHECK(text_of(RenderingModel()).empty());
  CHECK(text_of(all) == "blur=0.1,antialiased=yes,order=distance,colours=linear,kernel=disk");
  CHECK(model_from(text_of(all)) == all);
  CHECK(model_from("", all) == all);
  CHECK(model_from("antialiased=no,blur=0", all).blur == 0);
  CHECK(model_from("antialiased=no,blur=0", all).order == SplatOrder::distance);
}

TEST_CASE("model text: a setting that is not known is refused by name") {
  for (const char* text :
       {"antialiased", "antialiased=", "order=z", "blur", "size=3", ",", "kernel=disk=disk"}) {
    CAPTURE(text);
    CHECK_THROWS_WITH_AS(model_from(text), doctest::Contains("is not known; expected"),
                         std::invalid_argument);
  }
  for (const char* text : {"blur=-1", "blur=", "blur=1px", "blur=nan", "blur=inf"}) {
    CAPTURE(text);
    CHECK_THROWS_WITH_AS(model_from(text), doctest::Contains("the blur is"), std::invalid_argument);
  }
}

TEST_CASE("model: PLY files keep it, other formats say what they leave out") {
  Scene scene = some_scene(40, 1);
  for (vec3& scale : scene.scales) scale.z = 0;  // as of disks
  for (const RenderingModel& model : {RenderingModel(), RenderingModel{.antialiased = true}, all,
                                      RenderingModel{.kernel = RenderingModel::Kernel::disk}})
    for (const auto& [ending, holds] :
         {std::pair{".ply", model},
          {".compressed.ply", model},
          {".spz", {.antialiased = model.antialiased}},
          {".sog",
           {.antialiased = model.antialiased,
           .kernel = model.antialiased ? RenderingModel().kernel : model.kernel}},
          {".splat", {}}}) {
      CAPTURE(ending);
      CAPTURE(text_of(model));
      scene.model = model;
      const Written written = write_and_read(scene, ending);
      CHECK(written.scene().model == holds);
      const std::string notes = all_notes(written.notes);
      CHECK(contains(notes, "How the scene was trained to be drawn is left out: ") == (holds != model));
      if (holds == RenderingModel() && model != holds) CHECK(contains(notes, text_of(model)));
    }
}

TEST_CASE("model: PLY comments in any letters count, and those of other programs change nothing") {
  const auto model = [](const std::string& comments) {
    return read(ply(plain_gaussian(), {.before = comments})).scene.model;
  };
  const RenderingModel mip{.antialiased = true};
  CHECK(model("comment splatrendermode: mip\n") == mip);
  CHECK(model("comment SPLATRENDERMODE: Mip\n") == mip);
  CHECK(model("comment RenderingModel: blur=0.1,order=distance\n") ==
        RenderingModel{.blur = 0.1f, .order = SplatOrder::distance});
  CHECK(model("comment RenderingModel: of clay\n") == RenderingModel());
  const SceneFile later = read(ply(plain_gaussian(), {.before = "comment RenderingModel: blur=5,aa=yes\n"}));
  CHECK(later.scene.model == RenderingModel());
  CHECK(later.notes == std::vector<std::string>{
                           "The comment on the rendering model is not known, and ignored: blur=5,aa=yes."});
  CHECK(model("comment SplatRenderMode: hologram\n") == RenderingModel());
}

TEST_CASE("model: the 3D filter of Mip-Splatting comes with its 2D filter") {
  auto gaussian = plain_gaussian();
  gaussian.push_back({"float", "filter_3D", 0.25});
  const RenderingModel mip{.blur = 0.1f, .antialiased = true};
  CHECK(read(ply(gaussian)).scene.model == mip);
  CHECK(read(ply(gaussian, {.before = "comment RenderingModel: blur=0.3,antialiased=no\n"})).scene.model ==
        RenderingModel());
}
