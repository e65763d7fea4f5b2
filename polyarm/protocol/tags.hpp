#pragma once
/// Requests about tags, about forcing them, and about links.
#include "polyarm/protocol/facts.hpp"

namespace polyarm::protocol {

/// The value of an output when the program stops, the cell holds, or a link is lost.
struct TagRules {
  std::optional<Any> on_stop, on_hold, on_link_loss;
  POLYARM_MEMBERS(TagRules, on_stop, on_hold, on_link_loss)
};

struct TagState {
  std::string name, type, unit;
  Any value;  ///< a flag, number or text
  std::string text, direction, source, quality;
  bool forced = false, tag = false;
  OrNull<double> changed_s;
  std::string changed_by;
  OrNull<double> output;  ///< last value sent
  TagRules rules;
  POLYARM_MEMBERS(TagState, name, type, unit, value, text, direction, source, quality, forced, tag, changed_s,
                  changed_by, output, rules)
};

struct LinkState {
  std::string name, address;
  bool up = false;
  std::string reason;
  std::uint64_t losses = 0, exchanges = 0;
  double round_ms = 0;
  std::string on_loss;
  std::size_t tags = 0;
  POLYARM_MEMBERS(LinkState, name, address, up, reason, losses, exchanges, round_ms, on_loss, tags)
};

struct TagsList {
  static constexpr Facts kFacts{
      .name = "tags.list",
      .role = Role::watch,
      .text = "Returns all tags, or those in `names` (variables of the data, too), and the links."};
  std::optional<Names> names;
  struct Answer {
    static constexpr const char* kOf = "TagsList";
    std::vector<TagState> tags;
    std::vector<LinkState> links;
    POLYARM_MEMBERS(Answer, tags, links)
  };
  POLYARM_MEMBERS(TagsList, names)
};

struct TagsSet {
  static constexpr Facts kFacts{
      .name = "tags.set",
      .role = Role::operate,
      .text =
          "Sets a tag or variable once, as a person. `by` is reported as the author of the change; the "
          "port of the pendant uses the name of its client.",
      .moves = true};
  std::string name;
  Any value;
  std::optional<std::string> by;
  using Answer = TagState;
  POLYARM_MEMBERS(TagsSet, name, value, by)
};

struct TagsForce {
  static constexpr Facts kFacts{
      .name = "tags.force",
      .role = Role::operate,
      .text =
          "Forces a tag to a value until `tags.release`, or until this client disconnects. Answered "
          "repeatedly.",
      .moves = true};
  std::string name;
  Any value;
  std::optional<std::string> by;
  using Answer = TagState;
  POLYARM_MEMBERS(TagsForce, name, value, by)
};

struct TagsRelease {
  static constexpr Facts kFacts{
      .name = "tags.release",
      .role = Role::operate,
      .text = "Ends the forcing of a tag, by whichever client. The tag follows its source again.",
      .moves = true};
  std::string name;
  std::optional<std::string> by;
  using Answer = TagState;
  POLYARM_MEMBERS(TagsRelease, name, by)
};

struct TagChange {
  std::uint64_t number = 0;
  std::string name;
  OrNull<std::string> old, now;
  std::string by;
  POLYARM_MEMBERS(TagChange, number, name, old, now, by)
};

struct TagsHistory {
  static constexpr Facts kFacts{
      .name = "tags.history",
      .role = Role::watch,
      .text =
          "Lists the newest 1024 changes of tags, variables and points, oldest first, with their "
          "authors; with `after`, those after that number."};
  std::optional<Names> names;
  std::optional<double> after;
  struct Answer {
    static constexpr const char* kOf = "TagsHistory";
    std::uint64_t last = 0;
    std::vector<TagChange> changes;
    POLYARM_MEMBERS(Answer, last, changes)
  };
  POLYARM_MEMBERS(TagsHistory, names, after)
};

}  // namespace polyarm::protocol
