#pragma once
/// Texts as they might come from a broken disk, a merge or a bad day.
#include <random>
#include <string>
#include <vector>

namespace polyarm::test {

/// `text` after one to six changes: something taken out (up to `longest` characters), one of `pieces` or some
/// of the text itself put in, a character replaced.
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
