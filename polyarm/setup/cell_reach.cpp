#include "polyarm/setup/cell_reach.hpp"

#include <algorithm>
#include <set>

#include "polyarm/base/text.hpp"
#include "polyarm/plugins/plugins.hpp"
#include "polyarm/base/approvals.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/secrets.hpp"
#include "polyarm/base/shell_word.hpp"

namespace polyarm::cell {

namespace {
namespace fs = std::filesystem;
using signals::LinkEntry;

std::string subject_of(const CellFile& file) {
  return project_root(file.folder).string();
}

bool secret_allowed(const CellFile& file, const std::string& name) {
  return reach().secret_allowed(name, file.grant.get()) || is_approved({"secret", subject_of(file), name});
}

/// Hosts that a cell on the ROS graph talks to, if that is more than this machine.
std::vector<std::string> graph_hosts(const std::map<std::string, std::string>& graph) {
  std::vector<std::string> out;
  const auto range = graph.find("range"), peers = graph.find("peers");
  if (range != graph.end() && (lower(range->second) == "subnet" || lower(range->second) == "system_default"))
    out.emplace_back("subnet");
  if (peers != graph.end())
    for (const std::string& peer : split_words(peers->second, ", ;")) out.push_back(peer);
  return out;
}

std::vector<std::string> hosts_of(const LinkEntry& link) {
  return link.kind == "ros2" ? graph_hosts(link.graph) : std::vector<std::string>{link.host};
}

class List {
 public:
  explicit List(const CellFile& file) : file_(file) {}

  std::vector<Wanted> all(Problems& unread) {
    plugins();
    own_files();
    for (const RobotEntry& robot : file_.robots) of_robot(robot);
    for (const auto& [name, options] : file_.doors)
      for (const std::string& host : graph_hosts(options)) add("host", host, "the door " + name, {});
    for (const StreamEntry& stream : file_.streams) {
      const bool device = stream.kind == StreamEntry::Kind::device,
                 listens = stream.kind == StreamEntry::Kind::listen;
      add(device ? "device" : "host", device ? stream.device : stream.host,
          "the stream '" + stream.name + "'" + (listens ? ", which listens there" : ""), stream.where);
    }
    collect(unread, [&] { links(); });
    return std::move(out_);
  }

 private:
  void add(const char* kind, const std::string& what, const std::string& why, const Location& where) {
    Wanted wanted{kind, what, why, where, false};
    if (wanted.kind == "host")
      wanted.allowed = reach().host_allowed(what, file_.grant.get()) || is_approved({"host", subject_of(file_), what});
    if (wanted.kind == "host" && is_loopback(what)) return;
    if (wanted.kind == "device") wanted.allowed = true;  // opened only with --real, which the user gives
    if (wanted.kind == "secret") wanted.allowed = secret_allowed(file_, what);
    if (seen_.insert({wanted.kind, what}).second) out_.push_back(std::move(wanted));
  }

  /// Adds a file, unless it is inside the project or allowed.
  void file(const fs::path& named, const std::string& why, const Location& where, Reach::Use use) {
    if (named.empty()) return;
    const fs::path path = file_.folder / named, real = resolved(path);
    if (polyarm::inside(real, project_root(file_.folder)) || reach().allows(path, real, use)) return;
    if (is_approved({"path", subject_of(file_), real.string()})) return;
    add("file", real.string(), why, where);
  }

  void plugins() {
    for (const std::string& written : file_.plugins) {
      std::error_code error;
      const fs::path folder = file_.folder / written;
      if (!fs::is_directory(folder, error)) continue;
      for (const plugins::Library& library : plugins::look_at(folder)) {
        out_.push_back({"plugin", library.file.lexically_normal().string(), "plugins: " + written,
                        file_.plugins_where, library.approved, library.sha256});
      }
    }
  }

  void own_files() {
    file(file_.scene, "scene", file_.scene_where, Reach::Use::read);
    file(file_.signals, "signals", file_.signals_where, Reach::Use::read);
    file(file_.program, "program", file_.program_where, Reach::Use::read);
    file(file_.plc, "plc", file_.plc_where, Reach::Use::read);
    for (const std::string& name : file_.controllers)
      file(name, "controllers", file_.controllers_where, Reach::Use::read);
    if (file_.record) file(file_.record->file, "record", {}, Reach::Use::write);
  }

  void of_robot(const RobotEntry& robot) {
    std::error_code error;
    for (const std::string& named : {robot.model, robot.tool})
      if (fs::path(named).is_absolute() || named.starts_with("../") || named.find("/../") != std::string::npos)
        file(named, "robot " + robot.name, robot.where, Reach::Use::read);
    for (const auto& [key, value] : robot.parameters) {
      const std::string why = key + " of robot " + robot.name, name = lower(key);
      if (value.starts_with("/dev/"))
        add("device", value, why, robot.where);
      else if (name == "host" || name == "hostname" || name == "ip" || name == "robot_ip" ||
               name == "address" || name == "ip_address")
        add("host", value, why, robot.where);
      else if (value.starts_with(kSecretPrefix))
        add("secret", value.substr(kSecretPrefix.size()), why, robot.where);
      else if (value.find('/') != std::string::npos && fs::exists(file_.folder / value, error))
        file(value, why, robot.where, Reach::Use::read);
    }
  }

  void links() {
    if (file_.signals.empty()) return;
    const signals::Signals read = signals::load_signals((file_.folder / file_.signals).string());
    for (const LinkEntry& link : read.links) {
      const std::string why = "the link '" + link.name + "'" + (link.server ? ", which listens there" : "");
      for (const std::string& host : hosts_of(link)) add("host", host, why, link.where);
      for (const std::string& named : {link.password_file, link.ca_file, link.certificate, link.key})
        if (named.starts_with(kSecretPrefix))
          add("secret", named.substr(kSecretPrefix.size()), why + " to " + link.host, link.where);
        else if (!named.empty())
          file(fs::absolute(named), why, link.where, Reach::Use::read);
    }
  }

  const CellFile& file_;
  std::vector<Wanted> out_;
  std::set<std::pair<std::string, std::string>> seen_;
};

void admit_host(const CellFile& file, const std::string& host, const std::string& who, const Location& where,
                Problems& problems) {
  if (reach().host_allowed(host, file.grant.get())) return;
  problems.error("host-not-allowed", where,
                 who + " accesses " + (host == "subnet" ? "the whole network (subnet)" : "the host " + host) +
                     ", which you have not allowed",
                 "if you trust the cell, run it at a terminal and answer, or add --allow " + shell_word("host:" + host) +
                     " to the command");
}

/// False if the file is refused; adds a problem then. Replaces a secret by its file.
bool admit_file(const CellFile& file, const LinkEntry& link, std::string& named, Problems& problems) {
  if (named.empty()) return true;
  const std::size_t before = problems.list().size();
  const auto admitted = [&] { return problems.list().size() == before; };
  if (!named.starts_with(kSecretPrefix)) {
    collect(problems, [&] { reach().check(named, Reach::Use::read); });
    return admitted();
  }
  const std::string name = named.substr(kSecretPrefix.size());
  if (!secret_allowed(file, name)) {
    problems.error("secret-not-allowed", link.where,
                   "the link '" + link.name + "' sends your secret '" + name + "' to " + link.host +
                       ", which you have not allowed",
                   "if you trust the cell, run it at a terminal and answer, or add --allow " + shell_word("secret:" + name) +
                       " to the command");
    return false;
  }
  collect(problems, [&] {
    const fs::path path = secret_file(name);
    mark_secret(path);
    file.grant->allow_reading(path);
    named = path.string();
  });
  return admitted();
}
}  // namespace

std::vector<Wanted> required_by(const CellFile& file, Problems* unread) {
  Problems told_later;
  return List(file).all(unread ? *unread : told_later);
}

void allow_remembered(const CellFile& file) {
  if (AsUser::active() || !reach().confined()) return;
  const std::string subject = subject_of(file);
  for (const Approval& each : approvals()) {
    if (each.subject != subject) continue;
    if (each.kind == "host") file.grant->allow_host(each.what);
    if (each.kind == "path") file.grant->allow(each.what);
  }
}

void remember_allowed(const CellFile& file, const Wanted& wanted) {
  if (wanted.kind == "plugin") return approve({"library", wanted.sha256, wanted.what});
  if (wanted.kind == "device") return;
  approve({wanted.kind == "file" ? "path" : wanted.kind, subject_of(file), wanted.what});
}

void allow_and_remember(const CellFile& file, const Wanted& wanted) {
  if (wanted.kind == "host") file.grant->allow_host(wanted.what);
  if (wanted.kind == "file") file.grant->allow(wanted.what);
  remember_allowed(file, wanted);
}

void admit_links(const CellFile& file, signals::Signals& signals, Problems& problems) {
  for (LinkEntry& link : signals.links) {
    for (const std::string& host : hosts_of(link))
      admit_host(file, host, "the link '" + link.name + "'", link.where, problems);
    // Do not test a refused file again for the link's port; this would report it twice.
    std::set<std::string> refused;
    for (std::string* named : {&link.password_file, &link.ca_file, &link.certificate, &link.key}) {
      const std::string written = *named;
      if (refused.contains(written) || !admit_file(file, link, *named, problems)) {
        refused.insert(written);
        named->clear();
      }
    }
  }
}

void admit_robots(const CellFile& file, Problems& problems) {
  for (const RobotEntry& robot : file.robots)
    for (const auto& [key, value] : robot.parameters) {
      if (!value.starts_with(kSecretPrefix)) continue;
      const std::string name = value.substr(kSecretPrefix.size());
      const auto host = robot.parameters.find("host");
      if (!secret_allowed(file, name))
        problems.error("secret-not-allowed", robot.where,
                       "the hardware of '" + robot.name + "' sends your secret '" + name + "' to " +
                           (host == robot.parameters.end() ? "its device" : host->second) +
                           ", which you have not allowed",
                       "if you trust the cell, run it at a terminal and answer, or add --allow " +
                           shell_word("secret:" + name) + " to the command");
      else if (file.grant)
        collect(problems, [&] { file.grant->allow_reading(secret_file(name)); });
    }
}

void admit_streams(const CellFile& file, Problems& problems) {
  for (const StreamEntry& stream : file.streams)
    if (stream.kind != StreamEntry::Kind::device)
      admit_host(file, stream.host, "the stream '" + stream.name + "'", stream.where, problems);
}

void admit_doors(const CellFile& file, Problems& problems) {
  for (const auto& [name, options] : file.doors)
    for (const std::string& host : graph_hosts(options))
      admit_host(file, host, "the door '" + name + "'", {file.path.string()}, problems);
}

}  // namespace polyarm::cell
