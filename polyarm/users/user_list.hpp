#pragma once
/// The users of the pendant's port: names, roles and hashes of passwords, in one file that only its owner can
/// read. A line has a name, a role and a hash.
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/protocol/facts.hpp"

namespace polyarm::users {

inline constexpr std::size_t kMostUsers = bounds::kUsers, kMostName = bounds::kUserNameBytes,
                             kMostListBytes = bounds::kUserListBytes;

struct User {
  std::string name;
  protocol::Role role = protocol::Role::watch;
  std::string hash;
};

/// Throws Error("bad-user"): a name begins with a letter and has letters, digits and . _ -
void require_good_name(const std::string& name);
/// The role of a word: watch, operate, program, administer; view is the same as watch. Throws
/// Error("bad-role").
protocol::Role role_of_word(const std::string& word);

class UserList {
 public:
  const std::vector<User>& all() const { return users_; }
  const User* find(const std::string& name) const;
  /// Throws Error("bad-user" | "too-many").
  void add(User user);
  /// Throws Error("unknown-user").
  User& at(const std::string& name);
  void remove(const std::string& name);
  std::string text() const;

 private:
  std::vector<User> users_;
};

/// Throws Error("bad-users") with file and line.
UserList parse_users(std::string_view text, const std::string& file = "users");
/// A missing file is an empty list. Throws Error("bad-users"), also if others may read or write the file.
UserList read_users(const std::filesystem::path& file);
/// Reads, changes and replaces the file (mode 0600) while no other process does. Throws Error.
void change_users(const std::filesystem::path& file, const std::function<void(UserList&)>& change);

/// The folder for users and the audit log: polyarm/ in $XDG_DATA_HOME or ~/.local/share. Empty if there is no
/// home.
std::filesystem::path folder_of_user();
inline std::filesystem::path users_file(const std::filesystem::path& folder) {
  return folder / "users";
}
/// Creates the folder with mode 0700 if it is missing. Throws Error("no-folder").
void make_private_folder(const std::filesystem::path& folder);

}  // namespace polyarm::users
