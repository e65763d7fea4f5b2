#pragma once
/// Damages texts at random, as a broken disk, a bad merge or a mistake might.
#include <random>
#include <string>
#include <vector>

namespace polyarm::test {

/// `text` after one to six changes: removes up to `longest` characters, inserts one of `pieces` or a part of
/// the text, or replaces a character.
inline std::string damaged(std::string text, const std::vector<std::string>& pieces, std::size_t longest,
                           std::mt19937& random) {
  const auto pick = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  const std::size_t times = 1 + pick(6);
  for (std::size_t i = 0; i < times; ++i) {
    const std::size_t at = pick(text.size() + 1), length = pick(longest);
    switch (pick(4)) {
      case 0:
        text.erase(at, length);
        break;
      case 1:
        text.insert(at, pieces[pick(pieces.size())]);
        break;
      case 2:
        text.insert(at, text.substr(pick(text.size() + 1), length * 4));
        break;
      default:
        if (at < text.size()) text[at] = static_cast<char>(random());
    }
  }
  return text;
}

}  // namespace polyarm::test
