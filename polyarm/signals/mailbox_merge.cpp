#include "polyarm/signals/mailbox_merge.hpp"

#include <algorithm>
#include <limits>

namespace polyarm::signals {

std::size_t differences(const Values& a, const Values& b) {
  std::size_t count = 0;
  auto x = a.begin(), y = b.begin();
  while (x != a.end() && y != b.end()) {
    if (x->first == y->first) {
      if (!(x->second == y->second)) ++count;
      ++x, ++y;
    } else {
      ++count;
      x->first < y->first ? static_cast<void>(++x) : static_cast<void>(++y);
    }
  }
  return count + static_cast<std::size_t>(std::distance(x, a.end()) + std::distance(y, b.end()));
}

std::vector<std::pair<std::string, std::string>> regrouped(const data::DataSet& before,
                                                           const data::DataSet& after) {
  std::vector<std::pair<std::string, std::string>> out;
  for (const data::Entry& entry : after.entries()) {
    const data::Entry* old = before.find(entry.name);
    if (entry.group != (old ? old->group : "")) out.emplace_back(entry.name, entry.group);
  }
  return out;
}

MailboxMerge::MailboxMerge(Values start, std::size_t kept)
    : present_{std::move(start)}, kept_{std::max<std::size_t>(2, kept)} {
  remember(present_);
}

void MailboxMerge::remember(Values values) {
  versions_.push_back({next_++, std::move(values)});
  if (versions_.size() > kept_) versions_.pop_front();
}

bool MailboxMerge::set(const std::string& name, const data::Value& value) {
  const auto at = present_.find(name);
  if (at != present_.end() && at->second == value) return false;
  present_.insert_or_assign(name, value);
  return true;
}

std::uint64_t MailboxMerge::wrote() {
  remember(present_);
  return current();
}

const MailboxMerge::Version* MailboxMerge::nearest(const Values& content,
                                                   std::span<const std::uint64_t> among) const {
  const Version* best = nullptr;
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  for (auto version = versions_.rbegin(); version != versions_.rend(); ++version) {
    if (!among.empty() && std::find(among.begin(), among.end(), version->number) == among.end()) continue;
    const std::size_t count = differences(content, version->values);
    if (count >= fewest) continue;
    fewest = count;
    best = &*version;
  }
  return best;
}

MailboxMerge::Result MailboxMerge::outside(const Values& content, std::span<const std::uint64_t> read) {
  const Version* known = nearest(content, read);
  const Version& base = known ? *known : *nearest(content, {});
  Result result;
  result.base = base.number;
  for (const auto& [name, value] : content) {
    const auto before = base.values.find(name);
    if (before != base.values.end() && before->second == value) continue;
    if (set(name, value)) result.changes.emplace_back(name, value);
  }
  result.write_back = differences(present_, content) > 0;
  Values complete = content;
  complete.insert(base.values.begin(), base.values.end());
  remember(std::move(complete));
  return result;
}

}  // namespace polyarm::signals
