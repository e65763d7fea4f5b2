#include "drivers/mock/injection.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::drivers {

using hardware::ReturnType;

namespace {
const std::vector<std::string> kKinds = {"read_error", "write_error", "deactivate", "nan",
                                         "jump",       "freeze",      "slow"};
constexpr const char* kForm =
    "KIND@CYCLE[:JOINT][=VALUE], for example nan@500:elbow_joint or slow@100=20; kinds are ";

double number_in(const std::string& text, const std::string& entry) {
  if (const auto value = parse_number(text); value && *value >= 0) return *value;
  throw Error("bad-value", "'" + text + "' in the fault '" + entry + "' is not a number of zero or more",
              kForm + join(kKinds, ", "));
}
}  // namespace

void Injection::parse(const std::string& text, const std::vector<std::string>& joints,
                      std::vector<int> positions, std::size_t states) {
  for (const std::string& whole : split_words(text, " ;,\t\n")) {
    std::string rest = whole;
    const auto cut = [&rest](char at) {
      const auto found = rest.find(at);
      std::string tail = found == std::string::npos ? "" : rest.substr(found + 1);
      rest = rest.substr(0, found);
      return tail;
    };
    const std::string value = cut('='), joint = cut(':'), cycle = cut('@');
    const auto kind = std::find(kKinds.begin(), kKinds.end(), rest);
    if (kind == kKinds.end())
      throw Error("bad-value", "there is no fault '" + rest + "'" + did_you_mean(rest, kKinds),
                  kForm + join(kKinds, ", "));
    Entry entry;
    entry.kind = static_cast<Kind>(kind - kKinds.begin());
    entry.cycle = static_cast<std::uint64_t>(number_in(cycle, whole));
    entry.value = entry.kind == Kind::jump ? 0.5 : 50;
    if (!value.empty()) {
      const auto given = parse_number(value);
      if (!given) number_in(value, whole);
      entry.value = *given;
    }
    const auto found =
        std::find(joints.begin(), joints.end(), joint.empty() && !joints.empty() ? joints.front() : joint);
    if (entry.kind == Kind::nan || entry.kind == Kind::jump) {
      if (found == joints.end() || positions[static_cast<std::size_t>(found - joints.begin())] < 0)
        throw Error("bad-value",
                    "the fault '" + whole + "' names no joint whose position is measured" +
                        did_you_mean(joint, joints),
                    "write one of " + join(joints, ", "));
      entry.state = static_cast<std::size_t>(positions[static_cast<std::size_t>(found - joints.begin())]);
      entry.joint = *found;
    }
    entries_.push_back(std::move(entry));
  }
  frozen_.assign(states, 0);
}

void Injection::begin() noexcept {
  cycle_ = 0;
  is_frozen_ = false;
  last_.store(-1, std::memory_order_relaxed);
}

ReturnType Injection::after_read(std::span<double> states) noexcept {
  ReturnType out = ReturnType::ok;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const Entry& e = entries_[i];
    const bool now = cycle_ == e.cycle;
    if (cycle_ < e.cycle || (!now && e.kind != Kind::nan && e.kind != Kind::jump)) continue;
    if (now) last_.store(static_cast<int>(i), std::memory_order_relaxed);
    if (e.kind == Kind::nan) states[e.state] = std::numeric_limits<double>::quiet_NaN();
    if (e.kind == Kind::jump) states[e.state] += e.value;
    if (e.kind == Kind::read_error) out = ReturnType::error;
    if (e.kind == Kind::deactivate) out = ReturnType::deactivate;
    if (e.kind == Kind::slow)
      for (const Nanoseconds until = realtime::monotonic_now() + static_cast<Nanoseconds>(e.value * 1e6);
           realtime::monotonic_now() < until;) {
      }
    if (e.kind == Kind::freeze) {
      is_frozen_ = true;
      std::copy(states.begin(), states.end(), frozen_.begin());
    }
  }
  if (is_frozen_) std::copy(frozen_.begin(), frozen_.end(), states.begin());
  ++cycle_;
  return out;
}

ReturnType Injection::after_write() const noexcept {
  for (const Entry& e : entries_)
    if (e.kind == Kind::write_error && e.cycle + 1 == cycle_) return ReturnType::error;
  return ReturnType::ok;
}

std::string Injection::reason() const {
  const int last = last_.load(std::memory_order_relaxed);
  if (last < 0) return {};
  const Entry& e = entries_[static_cast<std::size_t>(last)];
  return "injected fault: " + kKinds[static_cast<std::size_t>(e.kind)] +
         (e.joint.empty() ? "" : " of " + e.joint) + " at cycle " + std::to_string(e.cycle);
}

}  // namespace polyarm::drivers
