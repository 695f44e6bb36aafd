// SPDX-License-Identifier: Apache-2.0

// One frame over ranks: mpirun -n 4 11_mpi_frame [SCENE.ply]. Each rank holds a part of the scene and draws a
// strip of the image; rank 0 collects it. No rank ever holds the whole scene.
#include <cstdio>
#include <functional>
#include <utility>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/mpi.hpp>
#include <swiftgs/swiftgs.hpp>

using namespace swiftgs;

int draw(const char* file, Ranks& ranks) {
  // Rank r takes part r: what it draws in front or behind follows from the order of the scene.
  const ScenePart own{std::size_t(ranks.rank()), std::size_t(ranks.size())};
  if (file) ranks.require_same(file, file_identity(file));
  Scene read = file ? load_scene(file, {.part = own}) : make_builtin_scene(200'000, own);

  // As a `Renderer`, but all its functions are collective. With <swiftgs/mpi/cuda.hpp> and
  // `take_device(ranks)` before it, Cuda stands in place of Cpu.
  DistributedRenderer<Cpu> renderer(ranks);
  const auto part = renderer.backend().upload(std::move(read));

  Frame frame;  // filled on rank 0
  for (int k = 0; k < 4; ++k) {
    renderer.render(part.view(), builtin_camera(), {}, frame);
    if (ranks.rank() != 0) continue;
    const FrameCounters& counters = renderer.counters();
    std::printf("frame %d: %.2f MB in %llu messages, slowest strip %.2f times the mean\n", k,
                1e-6 * double(counters.sent_bytes()), static_cast<unsigned long long>(counters.messages()),
                counters.imbalance());
  }
  if (ranks.rank() == 0) write_png("mpi_frame.png", frame);
  return 0;
}

// Starts MPI, and ends all ranks with one line where one of them throws.
int main(int argc, char** argv) {
  return run_on_ranks("11_mpi_frame", std::bind_front(draw, argc > 1 ? argv[1] : nullptr));
}
