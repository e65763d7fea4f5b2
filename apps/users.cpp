#include <fmt/format.h>
#include <termios.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/options.hpp"
#include "apps/verb.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/users/password.hpp"
#include "polyarm/users/user_list.hpp"

namespace polyarm::apps {

namespace {

namespace fs = std::filesystem;

struct UsersArguments {
  std::string name, role;
  fs::path folder;
  bool json = false;
};

/// Switches the terminal's echo off for its lifetime.
class Unseen {
 public:
  Unseen() {
    if (::tcgetattr(STDIN_FILENO, &before_) != 0) return;
    termios now = before_;
    now.c_lflag &= ~static_cast<tcflag_t>(ECHO);
    now.c_lflag |= ECHONL;
    changed_ = ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &now) == 0;
  }
  ~Unseen() {
    if (changed_) ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &before_);
  }
  Unseen(const Unseen&) = delete;
  Unseen& operator=(const Unseen&) = delete;

 private:
  termios before_{};
  bool changed_ = false;
};

std::string read_line() {
  std::string out;
  for (char c = 0; out.size() <= users::kMostPassword + 1 && ::read(STDIN_FILENO, &c, 1) == 1 && c != '\n';)
    out += c;
  return out;
}

/// Asked twice at a terminal; else one line of standard input. Never an argument: others can read command
/// lines.
std::string new_password(const std::string& name) {
  if (::isatty(STDIN_FILENO) == 0) return read_line();
  const auto ask = [&](const char* which) {
    fmt::print(stderr, "{} of {}: ", which, name);
    std::fflush(stderr);
    const Unseen unseen;
    return read_line();
  };
  const std::string first = ask("password");
  users::require_good_password(first);
  if (ask("again, the password") != first)
    throw Error("bad-password", "the two passwords differ", "try again");
  return first;
}

void print_list(const users::UserList& list, bool json) {
  if (json) {
    nlohmann::ordered_json out = nlohmann::ordered_json::array();
    for (const users::User& user : list.all())
      out.push_back({{"name", user.name}, {"role", protocol::name(user.role)}});
    fmt::print("{}\n", out.dump());
    return;
  }
  if (list.all().empty()) fmt::print("there are no users: the pendant is opened with its link\n");
  for (const users::User& user : list.all()) fmt::print("{:<34}{}\n", user.name, protocol::name(user.role));
}

int change(const std::string& verb, UsersArguments& a) {
  const fs::path file = users::users_file(a.folder);
  if (verb == "list") {
    print_list(users::read_users(file), a.json);
    return kOk;
  }
  std::optional<protocol::Role> role;
  std::string hash;
  if (verb == "add" || verb == "role") role = users::role_of_word(a.role);
  if (verb == "add") users::require_good_name(a.name);
  if (verb == "password")
    users::UserList(users::read_users(file)).at(a.name);  // before the password is asked
  if (verb == "add" || verb == "password") hash = users::hash_of(new_password(a.name));
  users::change_users(file, [&](users::UserList& list) {
    if (verb == "add") return list.add({a.name, *role, hash});
    if (verb == "remove") return list.remove(a.name);
    users::User& user = list.at(a.name);
    if (role) user.role = *role;
    if (!hash.empty()) user.hash = hash;
  });
  const char* const done = verb == "add" ? "can log in now" : verb == "remove" ? "is removed" : "is changed";
  fmt::print("{} {}{}\n", a.name, done,
             verb == "add" ? "" : "; open log-ins of this user end within a second or two");
  return kOk;
}

}  // namespace

int run_users(int argc, char** argv) {
  CommandLine app("Users who log in at the pendant's port with name and password", "polyarm users");
  UsersArguments a;
  a.folder = users::folder_of_user();
  app.add_option("--folder", a.folder,
                 "folder of users and audit log (default: polyarm/ in $XDG_DATA_HOME or ~/.local/share)");
  app.require_subcommand();
  app.add_subcommand("list", "names and roles")->add_flag("--json", a.json, "as JSON");
  const auto named = [&](const char* verb, const char* help) {
    CommandLine* const sub = app.add_subcommand(verb, help);
    sub->add_option("name", a.name, "letters, digits and . _ -")->required();
    return sub;
  };
  for (CommandLine* sub : {named("add", "add a user; the password is asked, or read from standard input"),
                           named("role", "change the role of a user")})
    sub->add_option("--role", a.role, "watch, operate, program or administer")->required();
  named("remove", "remove a user");
  named("password", "change a password");
  app.footer(examples({"polyarm users add anna --role operate", "polyarm users list",
                       "sudo -u polyarm polyarm users --folder /var/lib/polyarm add anna --role operate"}) +
             "\nExit codes: 0 done, 1 refused, 2 wrong command line\n");
  if (const auto code = app.parse(argc, argv)) return *code;
  return change(app.subcommand(), a);
}

}  // namespace polyarm::apps
