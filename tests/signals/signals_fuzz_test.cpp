/// Files of signals that are damaged in every way end in signals and problems, never in anything else.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "polyarm/base/file.hpp"
#include "polyarm/signals/tags.hpp"

namespace polyarm::signals {
namespace {

std::vector<std::string> signals_files() {
  std::vector<std::string> out = {
      "polyarm: signals/1\nlive: [a]\nheartbeat: {tag: Alive, every: 200ms}\nwatch: {PlcAlive: 2s}\n"
      "tags:\n  Alive: {initial: false, on_stop: false, on_hold: keep, on_link_loss: true, unit: mm}\n"
      "  Belt: {command: belt/speed, type: number, scale: 0.5}\npoints: {pick: {within: [[0, 0, 0], [1, 1, "
      "1]]}}\n"
      "links:\n  plc: {modbus: server, port: 1502, unit: 3, timeout: 2s, tags: {Belt: {holding: 4, format: "
      "float64, words: low_first, direction: out}, Alive: {coil: 0}}}\n  broker: {mqtt: localhost, qos: 1, "
      "will: gone, tags: {Alive: {topic: a/b, retained: true, json: x.y}}}\n"};
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(std::filesystem::path(POLYARM_SOURCE_DIR) / "examples"))
    if (entry.path().filename().string().ends_with("signals.yaml")) out.push_back(read_file(entry.path()));
  std::sort(out.begin(), out.end());
  return out;
}

TEST(SignalsFuzz, ThreeThousandDamagedFilesAreReadOrRefused) {
  static const std::string kBytes = "{}[]:,-#\"'&*!|>% \n\t0189ae_\\\x80\xC3\xFF";
  std::mt19937 random(7);
  const auto draw = [&](std::size_t below) {
    return std::uniform_int_distribution<std::size_t>(0, below - 1)(random);
  };
  const std::vector<std::string> files = signals_files();
  ASSERT_GT(files.size(), 5u);
  int good = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string text = files[static_cast<std::size_t>(i) % files.size()];
    for (std::size_t changes = 1 + draw(4); changes > 0 && !text.empty(); --changes) {
      const std::size_t at = draw(text.size());
      const std::string& other = files[draw(files.size())];
      switch (draw(4)) {
        case 0:
          text[at] = kBytes[draw(kBytes.size())];
          break;
        case 1:
          text.erase(at, 1 + draw(30));
          break;
        case 2:
          text.insert(at, other.substr(draw(other.size()), draw(60)));
          break;
        default:
          text.insert(at, 1, kBytes[draw(kBytes.size())]);
      }
    }
    Problems problems;
    try {
      const Signals signals = parse_signals(text, "signals.yaml", problems);
      for (const Tag& tag : signals.tags) EXPECT_FALSE(tag.name.empty()) << text;
    } catch (const Error& error) {
      EXPECT_FALSE(error.problems().empty());
      continue;
    }
    for (const Problem& problem : problems.list()) EXPECT_FALSE(problem.what.empty()) << text;
    good += problems.has_errors() ? 0 : 1;
  }
  EXPECT_GT(good, 100) << "damage that does not matter is not an error";
}

}  // namespace
}  // namespace polyarm::signals
