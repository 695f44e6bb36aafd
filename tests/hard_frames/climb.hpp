// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <iterator>
#include <map>
#include <type_traits>
#include <variant>
#include <vector>

/// @file
/// How searches climb.

namespace swiftgs::stress {

/// Climbs towards the largest values of several objectives at once. For each objective it keeps the candidate
/// of the largest value on every hill, and goes on from one of these. Where one hill is all there is, `Hill`
/// is left out.
template <class Candidate, class Hill = std::monostate>
class Climb {
 public:
  /// `moves_on_ties`: whether a candidate takes the place of a known one of the same value, so that the climb
  /// crosses plains.
  explicit Climb(std::size_t objectives, bool moves_on_ties = false)
      : hills_(objectives), moves_on_ties_(moves_on_ties) {}

  std::size_t objectives() const { return hills_.size(); }
  bool knows(std::size_t objective) const { return !hills_[objective].empty(); }

  /// What to judge next: `draw(random)` where `fresh` or where nothing is known of the objective, or else a
  /// known candidate, moved by `move(random, candidate)`.
  template <class Random, class Draw, class Move>
  Candidate next(Random& random, std::size_t objective, bool fresh, const Draw& draw,
                 const Move& move) const {
    if (fresh || !knows(objective)) return draw(random);
    Candidate candidate = parent(random, hills_[objective]).candidate;
    move(random, candidate);
    return candidate;
  }

  void offer(std::size_t objective, const Hill& hill, const Candidate& candidate, double value) {
    const double known = this->value(objective, hill);
    if (value > known || (moves_on_ties_ && value == known))
      hills_[objective].insert_or_assign(hill, Best{value, candidate});
  }

  /// -1 where nothing is known of the hill.
  double value(std::size_t objective, const Hill& hill = {}) const {
    const auto known = hills_[objective].find(hill);
    return known == hills_[objective].end() ? -1 : known->second.value;
  }

  /// Of a hill of which something is known.
  const Candidate& candidate(std::size_t objective, const Hill& hill = {}) const {
    return hills_[objective].at(hill).candidate;
  }

 private:
  struct Best {
    double value;
    Candidate candidate;
  };
  using Hills = std::map<Hill, Best>;

  /// The largest of one to four hills.
  template <class Random>
  static const Best& parent(Random& random, const Hills& hills) {
    if constexpr (std::is_same_v<Hill, std::monostate>) {
      return hills.begin()->second;
    } else {
      const Best* largest = nullptr;
      for (int i = 1 + random.below(4); i > 0; --i) {
        const Best& best = std::next(hills.begin(), random.below(int(hills.size())))->second;
        if (!largest || best.value > largest->value) largest = &best;
      }
      return *largest;
    }
  }

  std::vector<Hills> hills_;
  bool moves_on_ties_;
};

}  // namespace swiftgs::stress
