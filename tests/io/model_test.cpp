// SPDX-License-Identifier: Apache-2.0

// Rendering models as text, and in files.
#include <stdexcept>
#include <string>

#include <swiftgs/io/scene_file.hpp>

#include "ply_text.hpp"
#include "scenes.hpp"

namespace swiftgs::test::model_test {

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
  RenderingModel every = all;
  every.kernel = RenderingModel::Kernel::ellipsoid;
  const auto check = [&](const RenderingModel& model, const std::string& ending,
                         const RenderingModel& holds) {
    CAPTURE(ending);
    CAPTURE(text_of(model));
    scene.model = model;
    const Written written = write_and_read(scene, ending);
    CHECK(written.scene().model == holds);
    const std::string notes = all_notes(written.notes);
    CHECK(contains(notes, "How the scene was trained to be drawn is left out: ") == (holds != model));
    if (holds == RenderingModel() && model != holds) CHECK(contains(notes, text_of(model)));
  };
  for (const RenderingModel& model : {RenderingModel(), RenderingModel{.antialiased = true}, every}) {
    for (const char* ending : {".ply", ".compressed.ply"}) check(model, ending, model);
    for (const char* ending : {".spz", ".sog"}) check(model, ending, {.antialiased = model.antialiased});
    check(model, ".splat", {});
  }
}

TEST_CASE("model: files that can say so keep that Gaussians were disks") {
  Scene scene = some_scene(40, 1);
  for (vec3& scale : scene.scales) scale.z = 0;
  scene.model = {.kernel = RenderingModel::Kernel::disk};
  const TemporaryFolder folder;
  for (const char* ending : {".ply", ".compressed.ply", ".sog", ".spz"}) {
    CAPTURE(ending);
    const bool kept = std::string(ending) != ".spz";
    const WrittenScene written = write_scene(folder / ("a" + std::string(ending)), scene);
    const SceneFile file = read_scene(folder / ("a" + std::string(ending)));
    CHECK(written.model == file.scene.model);
    CHECK(file.scene.model == (kept ? scene.model : RenderingModel()));
    CHECK(contains(all_notes(file.notes), "trained as 2D ones") == kept);
    CHECK(contains(all_notes(written.notes), "is left out: kernel=disk.") == !kept);
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

}  // namespace swiftgs::test::model_test
