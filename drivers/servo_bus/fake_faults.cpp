#include "drivers/servo_bus/fake_faults.hpp"

#include <algorithm>
#include <numbers>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::servo_bus {

namespace {
const std::vector<std::string> kKinds = {"silent",    "cut",  "unplug",  "lose", "extra",
                                         "wrong_sum", "late", "garbage", "jump", "block"};

[[noreturn]] void refuse(const std::string& what) {
  throw Error("bad-value", what,
              "KIND@EXCHANGE[:JOINT][=VALUE], for example silent@300:elbow_flex or lose@100=3; kinds are " +
                  join(kKinds, ", "));
}

double number_in(const std::string& text, const std::string& entry, bool whole) {
  const auto value = parse_number(text);
  if (!value || (whole && (*value < 0 || *value > 1e9)))
    refuse("'" + text + "' in the fault '" + entry + "' is not a number" + (whole ? " of zero or more" : ""));
  return *value;
}
}  // namespace

void FakeFaults::parse(const std::string& text, const std::vector<JointSetup>& joints) {
  std::vector<std::string> names;
  for (const JointSetup& joint : joints) names.push_back(joint.name);
  for (const std::string& whole : split_words(text, " ;,\t\n")) {
    std::string rest = whole;
    const auto cut = [&rest](char at) {
      const auto found = rest.find(at);
      std::string tail = found == std::string::npos ? "" : rest.substr(found + 1);
      rest = rest.substr(0, found);
      return tail;
    };
    const std::string value = cut('='), name = cut(':'), exchange = cut('@');
    const auto kind = std::find(kKinds.begin(), kKinds.end(), rest);
    if (kind == kKinds.end()) refuse("there is no fault '" + rest + "'" + did_you_mean(rest, kKinds));
    const auto joint = std::find_if(joints.begin(), joints.end(), [&](const JointSetup& each) {
      return name.empty() || each.name == name || each.interface == name;
    });
    if (joint == joints.end())
      refuse("the fault '" + whole + "' names no joint of this bus" + did_you_mean(name, names));
    Entry entry;
    entry.kind = static_cast<Kind>(kind - kKinds.begin());
    entry.at = static_cast<std::uint64_t>(number_in(exchange, whole, true));
    const bool lasts = entry.kind == Kind::silent || entry.kind == Kind::cut;
    entry.value = entry.kind == Kind::jump ? 0.5 : lasts ? 0 : 1;
    if (!value.empty()) entry.value = number_in(value, whole, entry.kind != Kind::jump);
    entry.id = joint->id;
    entry.steps = joint->direction * 4096 / (2 * std::numbers::pi);
    entries_.push_back(entry);
  }
}

void FakeFaults::begin(const Entry& entry, FakeBus& bus, const Register& position) {
  const int count = static_cast<int>(entry.value);
  switch (entry.kind) {
    case Kind::silent:
      mischief_.silent.insert(entry.id);
      break;
    case Kind::cut:
      return bus.cut_off(true);
    case Kind::unplug:
      return bus.close_connection();
    case Kind::lose:
      mischief_.next_lose_byte = count;
      break;
    case Kind::extra:
      mischief_.next_extra_byte = count;
      break;
    case Kind::wrong_sum:
      mischief_.next_wrong_checksum = count;
      break;
    case Kind::late:
      mischief_.next_late = count;
      break;
    case Kind::garbage:
      mischief_.garbage = {0x00, 0xFF, 0x13, 0xFF, 0xFF};
      break;
    case Kind::jump:
      return bus.move_by_hand(entry.id,
                              bus.get(entry.id, position) + static_cast<int>(entry.value * entry.steps));
    case Kind::block:
      return bus.block(entry.id, true);
  }
  bus.mischief(mischief_);
  mischief_.next_lose_byte = mischief_.next_extra_byte = mischief_.next_wrong_checksum = mischief_.next_late =
      0;
}

bool FakeFaults::ends(const Entry& entry, std::uint64_t now) {
  return entry.value > 0 && now == entry.at + static_cast<std::uint64_t>(entry.value);
}

void FakeFaults::next(FakeBus& bus, const Register& position) {
  for (const Entry& entry : entries_) {
    if (entry.at == exchange_) begin(entry, bus, position);
    if (!ends(entry, exchange_)) continue;
    if (entry.kind == Kind::cut) bus.cut_off(false);
    if (entry.kind == Kind::silent) mischief_.silent.erase(entry.id);
    if (entry.kind == Kind::garbage) mischief_.garbage.clear();
    if (entry.kind == Kind::silent || entry.kind == Kind::garbage) bus.mischief(mischief_);
  }
  ++exchange_;
}

}  // namespace polyarm::servo_bus
