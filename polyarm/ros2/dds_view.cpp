#include "polyarm/ros2/dds_view.hpp"

#include <algorithm>
#include <utility>

#include "polyarm/base/bounds.hpp"

namespace polyarm::ros2 {

namespace {
/// ROS 2 uses less than 200 bytes of user data per endpoint.
constexpr std::size_t kUserDataKept = 512;
}  // namespace

bool DdsView::Endpoint::keep(std::span<const std::byte> payload) {
  if (!qos.transient_local || qos.renewed_by_owner) return false;
  kept.emplace_back(payload.begin(), payload.end());
  kept_bytes += payload.size();
  while (kept.size() > std::max<std::size_t>(1, qos.depth) ||
         (kept.size() > 1 && kept_bytes > bounds::kLatchedBytes)) {
    kept_bytes -= kept.front().size();
    kept.pop_front();
  }
  return true;
}

DdsView::Id DdsView::add(Endpoint endpoint) {
  endpoints_.emplace(++last_id_, std::move(endpoint));
  ++unanswered_;
  return last_id_;
}

bool DdsView::remove(Id id) {
  const auto at = endpoints_.find(id);
  if (at == endpoints_.end()) return false;
  unanswered_ -= at->second.answered ? 0 : 1;
  matches_ -= at->second.matched.size();
  endpoints_.erase(at);
  return true;
}

DdsView::Endpoint* DdsView::find(Id id) {
  const auto at = endpoints_.find(id);
  return at == endpoints_.end() ? nullptr : &at->second;
}

void DdsView::forget() {
  for (auto& [id, endpoint] : endpoints_) {
    endpoint.guid = kNoGuid;
    endpoint.answered = false;
    endpoint.sequence = 0;
    endpoint.matched.clear();
  }
  unanswered_ = endpoints_.size();
  matches_ = 0;
  remotes_.clear();
  prefix_ = kNoGuid;
}

void DdsView::set_prefix(const Guid& prefix) {
  prefix_ = prefix;
  ++identities_;
}

bool DdsView::take(DdsReport news, process::Unpacker& in) {
  switch (news) {
    case DdsReport::made: {
      const Id id = in.number<std::uint64_t>();
      const Guid guid = in.array<16>();
      if (in.good()) answer(id, guid);
      return in.good();
    }
    case DdsReport::not_made:
      answer(in.number<std::uint64_t>(), kNoGuid);
      return in.good();
    case DdsReport::unsent: {
      Endpoint* writer = find(in.number<std::uint64_t>());
      if (writer && writer->sequence > 0) --writer->sequence;
      return in.good();
    }
    case DdsReport::matched: {
      const Id id = in.number<std::uint64_t>();
      const Guid other = in.array<16>();
      const bool matches = in.truth();
      if (in.good()) match(id, other, matches);
      return in.good();
    }
    case DdsReport::known: {
      const Guid other = in.array<16>();
      Known known;
      known.user_data = in.text(kMostUserData);
      known.offer.topic = in.text(kMostName);
      known.offer.type = in.text(kMostName);
      if (in.good()) know(other, std::move(known));
      return in.good();
    }
    case DdsReport::unknown:
      remotes_.erase(in.array<16>());
      return in.good();
    case DdsReport::forgotten: {
      const Guid gone = in.array<16>();
      std::erase_if(remotes_, [&](const auto& remote) {
        return std::equal(gone.begin(), gone.begin() + 12, remote.first.begin());
      });
      return in.good();
    }
    default:
      return false;
  }
}

void DdsView::answer(Id id, const Guid& guid) {
  Endpoint* endpoint = find(id);
  if (!endpoint) return;
  unanswered_ -= std::exchange(endpoint->answered, true) ? 0 : 1;
  endpoint->guid = guid;
  ++identities_;
}

void DdsView::match(Id id, const Guid& other, bool matches) {
  Endpoint* endpoint = find(id);
  if (!endpoint) return;
  if (!matches)
    matches_ -= endpoint->matched.erase(other);
  else if (matches_ < bounds::kRemoteMatches)
    matches_ += endpoint->matched.try_emplace(other, Clock::now()).second ? 1 : 0;
}

void DdsView::know(const Guid& other, Known known) {
  if (remotes_.size() >= bounds::kRemoteEndpoints && !remotes_.contains(other)) return;
  known.user_data.resize(std::min(known.user_data.size(), kUserDataKept));
  remotes_[other] = std::move(known);
}

bool DdsView::is_offered(const std::string& topic, const std::string& type) const {
  return std::any_of(remotes_.begin(), remotes_.end(), [&](const auto& remote) {
    return remote.second.offer.topic == topic && remote.second.offer.type == type;
  });
}

Guid DdsView::guid(Id id) const {
  const Endpoint* endpoint = find(id);
  return endpoint ? endpoint->guid : kNoGuid;
}

bool DdsView::is_matched(Id id) const {
  const Endpoint* endpoint = find(id);
  return endpoint && !endpoint->matched.empty();
}

std::vector<Remote> DdsView::matched(Id id) const {
  std::vector<Remote> out;
  if (const Endpoint* endpoint = find(id))
    for (const auto& [guid, since] : endpoint->matched) out.push_back({guid, user_data(guid), since});
  return out;
}

std::string DdsView::user_data(const Guid& endpoint) const {
  const auto known = remotes_.find(endpoint);
  return known == remotes_.end() ? "" : known->second.user_data;
}

}  // namespace polyarm::ros2
