#include "polyarm/sweeps/variants.hpp"

#include <fmt/format.h>

#include <bit>
#include <numbers>

#include "polyarm/base/sha256.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::sweeps {

namespace {
/// Splitmix64: mixes all bits of a word (Steele, Lea, Flood: Fast splittable pseudorandom number generators).
std::uint64_t mixed(std::uint64_t word) {
  word = (word ^ (word >> 30)) * 0xbf58476d1ce4e5b9ULL;
  word = (word ^ (word >> 27)) * 0x94d049bb133111ebULL;
  return word ^ (word >> 31);
}
constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15ULL;
constexpr int kRounds = 4;
}  // namespace

Variants::Variants(const Sweep& sweep) : sweep_(sweep) {
  lengths_ = {sweep.robots.size(), sweep.places.size(), sweep.programs.size(),
              sweep.speeds.size(), sweep.faults.size(), sweep.seeds.size()};
  for (const ValueAxis& axis : sweep.values) lengths_.push_back(axis.values.size());
  if (sweep.combine == Combine::zip) {
    for (const std::uint64_t length : lengths_) {
      if (length == 1 || length == all_) continue;
      if (all_ > 1)
        throw Error("bad-zip", fmt::format("axes of {} and of {} values cannot be zipped", all_, length),
                    "give each of them the same number of values, or one; or combine: product");
      all_ = length;
    }
  } else {
    double count = 1;
    for (const std::uint64_t length : lengths_) count *= static_cast<double>(length), all_ *= length;
    if (count > kMostVariants)
      throw Error("too-many", fmt::format("{:.3g} variants are more than {:.3g}", count, kMostVariants),
                  "take fewer values of each axis");
  }
  count_ = sweep.sample ? std::min(*sweep.sample, all_) : all_;
}

/// A permutation of [0, all): a Feistel network on the next power of four, repeated until it falls inside.
std::uint64_t Variants::shuffled(std::uint64_t number) const {
  const int half = std::max(1, (static_cast<int>(std::bit_width(all_ - 1)) + 1) / 2);
  const std::uint64_t mask = (std::uint64_t{1} << half) - 1;
  do {
    std::uint64_t left = number >> half, right = number & mask;
    for (int round = 0; round < kRounds; ++round) {
      const std::uint64_t key = sweep_.sample_seed * kGolden + static_cast<std::uint64_t>(round);
      const std::uint64_t next = left ^ (mixed(right + mixed(key)) & mask);
      left = right;
      right = next;
    }
    number = (left << half) | right;
  } while (number >= all_);
  return number;
}

Variant Variants::at(std::uint64_t number) const {
  Variant out;
  out.number = number;
  std::uint64_t rest = sweep_.sample ? shuffled(number) : number;
  std::vector<std::uint64_t> index(lengths_.size());
  for (std::size_t axis = lengths_.size(); axis-- > 0;) {  // the last axis changes fastest
    if (sweep_.combine == Combine::zip) {
      index[axis] = lengths_[axis] == 1 ? 0 : rest;
    } else {
      index[axis] = rest % lengths_[axis];
      rest /= lengths_[axis];
    }
  }
  out.robot = sweep_.robots[index[0]];
  out.place = sweep_.places[index[1]];
  out.program = sweep_.programs[index[2]];
  out.speed = sweep_.speeds[index[3]];
  out.fault = &sweep_.faults[index[4]];
  out.seed = sweep_.seeds[index[5]];
  for (std::size_t i = 0; i < sweep_.values.size(); ++i)
    out.values.emplace_back(sweep_.values[i].name, sweep_.values[i].values[index[6 + i]]);
  return out;
}

std::string key_of(const Variant& variant, const std::string& robot_hash) {
  std::string all = fmt::format("{}\n{}\n", variant.robot, robot_hash);
  for (const auto& value : {variant.place.x, variant.place.y, variant.place.z, variant.place.yaw})
    all += (value ? format_number(*value) : "-") + "\n";
  all += fmt::format("{}\n{}\n{}\n{}\n{}\n", variant.program, format_number(variant.speed),
                     variant.fault->name, variant.fault->text, variant.seed);
  for (const auto& [name, value] : variant.values) all += name + "\n" + value + "\n";
  return sha256(all).substr(0, 32);
}

std::string text_of(const Place& place) {
  std::string out;
  const auto add = [&](const char* name, const std::optional<double>& value, double scale, const char* unit) {
    if (value) out += fmt::format("{}{} {:.4g}{}", out.empty() ? "" : ", ", name, *value * scale, unit);
  };
  add("x", place.x, 1, "");
  add("y", place.y, 1, "");
  add("z", place.z, 1, "");
  add("yaw", place.yaw, 180 / std::numbers::pi, "°");
  return out.empty() ? "as in the cell" : out;
}

std::string values_text(const Variant& variant) {
  std::string out;
  for (const auto& [name, value] : variant.values) out += (out.empty() ? "" : " ") + name + "=" + value;
  return out;
}

double Deviations::next() {
  state_ += kGolden;
  return static_cast<double>(mixed(state_) >> 11) * 0x1p-52 - 1;
}

}  // namespace polyarm::sweeps
