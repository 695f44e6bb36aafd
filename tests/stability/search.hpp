// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Search for the inputs that a stage errs most on. Random draws alone miss them: the worst cases hold
/// several coincidences at once.

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <swiftgs/project/sh.hpp>

#include "hard_frames/climb.hpp"
#include "policies/random_splats.hpp"

namespace swiftgs::test {

/// Climbs towards the largest error of several objectives at once, from fixed seeds. The first quarter of the
/// generations are draws; later ones are mostly neighbours of the worst candidates so far. A search is
/// repeated with other seeds `effort` times, so one of more effort finds at least as much.
template <class Candidate>
class Search {
 public:
  struct Best {
    Candidate candidate{};
    double value = -1;
  };

  Search(std::size_t objectives, int generations, int effort, std::uint64_t seed)
      : seed_(seed), generations_(generations), effort_(effort), now_(objectives), best_(objectives) {}

  /// draw(random) makes a candidate, move(random, candidate) changes one; judge(candidates, offer) measures a
  /// generation and calls offer(objective, candidate, value).
  template <class Draw, class Move, class Judge>
  void run(std::size_t size, const Draw& draw, const Move& move, const Judge& judge) {
    for (int repeat = 0; repeat < effort_; ++repeat) {
      now_ = stress::Climb<Candidate>(best_.size());
      Random random(seed_ + 7919 * std::uint64_t(repeat));
      std::vector<Candidate> generation(size);
      for (int g = 0; g < generations_; ++g) {
        for (std::size_t i = 0; i < size; ++i)
          generation[i] = now_.next(random, (i + std::size_t(g)) % best_.size(),
                                    4 * g < generations_ || i % 8 == 0, draw, move);
        judge(generation, [&](std::size_t objective, const Candidate& candidate, double value) {
          now_.offer(objective, {}, candidate, value);
        });
      }
      for (std::size_t i = 0; i < best_.size(); ++i)
        if (now_.value(i) > best_[i].value) best_[i] = {now_.candidate(i), now_.value(i)};
    }
  }

  /// What an objective has reached in the present repetition: less need not be judged exactly.
  double reached(std::size_t objective) const { return now_.value(objective); }
  const std::vector<Best>& best() const { return best_; }
  double value(std::size_t objective) const { return best_[objective].value; }

 private:
  std::uint64_t seed_;
  int generations_, effort_;
  stress::Climb<Candidate> now_;
  std::vector<Best> best_;
};

/// Moves `value` by a few floats, by a small part of itself, or not at all.
inline void nudge(Random& random, float& value) {
  switch (random.bits() % 4) {
    case 0: {
      const auto bits = std::bit_cast<std::uint32_t>(value) + std::uint32_t(random.bits() % 9) - 4;
      const auto moved = std::bit_cast<float>(bits);
      if (std::isfinite(moved)) value = moved;
      return;
    }
    case 1: {
      const float by = random.f(-1, 1);
      value *= 1 + by * float(random.scale(1e-7, 0.3));
      return;
    }
    default:
      return;
  }
}

/// Turns `q` a little, or leaves it.
inline void nudge(Random& random, Quaternion& q) {
  nudge(random, q.w), nudge(random, q.x), nudge(random, q.y), nudge(random, q.z);
  q = normalised(q);
}

}  // namespace swiftgs::test
