#include "apps/run_audit.hpp"

#include <pwd.h>
#include <unistd.h>

#include <array>

#include "polyarm/protocol/messages.hpp"
#include "polyarm/users/user_list.hpp"

namespace polyarm::apps {

namespace {

std::string name_of_this_user() {
  std::array<char, 4096> room{};
  passwd entry{};
  passwd* found = nullptr;
  if (::getpwuid_r(::geteuid(), &entry, room.data(), room.size(), &found) == 0 && found) return entry.pw_name;
  return std::to_string(::geteuid());
}

/// A client of the pendant's port; else one of the local socket, which only this user and root reach. ROS 2
/// carries no identity: if the cell has that door, the request may have come through it.
users::Actor actor_of(const void* from, const server::Pendant* pendant, const std::string& user, bool ros2) {
  if (from && pendant)
    if (const auto actor = pendant->actor(from)) return *actor;
  users::Actor out;
  out.name = from && !ros2 ? user : ros2 ? "ros2 or " + user : "the cell";
  out.role = protocol::name(protocol::Role::administer);
  out.door = from && !ros2 ? "local" : ros2 ? "local or ros2" : "inside";
  return out;
}

}  // namespace

std::unique_ptr<users::AuditLog> open_audit(cell::Observer& observer) {
  try {
    return std::make_unique<users::AuditLog>(users::audit_folder(users::folder_of_user()));
  } catch (const Error& e) {
    observer.on_note(std::string("warning: there is no audit log: ") + e.what());
    return nullptr;
  }
}

void audit(cell::CellView cell, users::AuditLog& log, const server::Pendant* pendant) {
  const std::string name = cell.file().name;
  cell.requests().set_witness(
      [&log, pendant, name, ros2 = cell.file().doors.contains("ros2"), user = name_of_this_user()](
          const void* from, const protocol::Request& request) -> std::function<void(const protocol::Reply&)> {
        const bool sends = &request.facts() == &protocol::SendMessage::kFacts;
        if (!sends && !users::is_audited(request.type(), request.arguments())) return {};
        users::AuditEntry entry;
        entry.cell = name;
        entry.actor = actor_of(from, pendant, user, ros2);
        entry.request = request.facts().name;
        entry.arguments = users::arguments_text(request);
        return [&log, entry = std::move(entry)](const protocol::Reply& reply) mutable {
          entry.outcome = reply.refusal ? reply.refusal->problems().front().code : "done";
          if (reply.refusal) entry.what = reply.refusal->problems().front().what;
          log.add(std::move(entry));
        };
      });
}

}  // namespace polyarm::apps
