#include "polyarm/fleet/site_file.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>

#include "polyarm/base/secrets.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::fleet {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void refuse(const Yaml& node, const std::string& what, const std::string& advice) {
  throw Error(Problem{"bad-site", node.where(), what, advice});
}

/// http://HOST[:PORT] or https://HOST[:PORT]
void read_address(const Yaml& node, SiteCell& out) {
  std::string rest = node.text();
  out.tls = rest.starts_with("https://");
  if (!out.tls && !rest.starts_with("http://"))
    refuse(node, "'" + rest + "' is no address of a cell", "for example https://192.168.1.20:8765");
  rest.erase(0, out.tls ? 8 : 7);
  rest = rest.substr(0, rest.find('/'));
  const auto colon = rest.rfind(':');
  const bool has_port = colon != std::string::npos && rest.find(']', colon) == std::string::npos;
  if (has_port) {
    const auto port = parse_number(rest.substr(colon + 1));
    if (!port || *port < 1 || *port > 65535 || *port != static_cast<std::uint16_t>(*port))
      refuse(node, "the port is no number from 1 to 65535", "for example https://192.168.1.20:8765");
    out.port = static_cast<std::uint16_t>(*port);
    rest.resize(colon);
  }
  if (rest.size() > 2 && rest.front() == '[' && rest.back() == ']') rest = rest.substr(1, rest.size() - 2);
  if (rest.empty() || rest.size() > 255 || rest.find_first_of("@?#[ ") != std::string::npos)
    refuse(node, "the address has no host",
           "for example https://192.168.1.20:8765; the token is in token_file");
  out.host = rest;
  in_addr four{};
  const bool loopback = rest == "localhost" || rest == "::1" ||
                        (rest.starts_with("127.") && ::inet_pton(AF_INET, rest.c_str(), &four) == 1);
  if (!out.tls && !loopback)
    refuse(node, "http to another machine would show the token to the network",
           "run the cell with --listen, and write https://");
}

std::string read_fingerprint(const Yaml& node) {
  std::string out;
  for (const char c : node.text(""))
    if (c != ':') out += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  if (!out.empty() && (out.size() != 64 || out.find_first_not_of("0123456789ABCDEF") != std::string::npos))
    refuse(node, "this is no SHA-256 of a certificate", "the terminal of the cell prints it: 3A:F1:…");
  return out;
}

SiteCell read_cell(const std::string& name, const Yaml& node, const fs::path& folder, Problems& problems) {
  SiteCell out;
  out.name = name;
  out.where = node.where();
  node.check_keys({"address", "token_file", "fingerprint", "ideal_cycle"}, problems);
  read_address(node.required("address"), out);
  out.fingerprint = read_fingerprint(node["fingerprint"]);
  if (out.tls && out.fingerprint.empty())
    refuse(node, "a cell with https needs the fingerprint of its certificate",
           "the terminal of the cell prints it: 3A:F1:…");
  out.ideal_cycle_s = node["ideal_cycle"].number(Dimension::time, 0);
  const std::string file = node.required("token_file").text();
  out.token = read_token_file(file.starts_with(kSecretPrefix) ? secret_file(file.substr(kSecretPrefix.size()))
                                                              : folder / file);
  return out;
}

}  // namespace

std::string read_token_file(const fs::path& file) {
  const auto wrong = [&](const std::string& what) {
    throw Error("bad-token", file.string() + " " + what,
                "store the token or the link of the cell in it, with mode 0600");
  };
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) wrong(std::string("cannot be read: ") + std::strerror(errno));
  struct stat status {};
  std::array<char, 1024> text{};
  const bool own = ::fstat(fd, &status) == 0 && S_ISREG(status.st_mode) && (status.st_mode & 0077) == 0;
  const ssize_t n = own ? ::read(fd, text.data(), text.size()) : 0;
  ::close(fd);
  if (!own) wrong("is not private: others may read it");
  mark_secret(file);
  std::string out(trim(std::string_view(text.data(), static_cast<std::size_t>(std::max<ssize_t>(0, n)))));
  if (const auto at = out.find("token="); at != std::string::npos) out = out.substr(at + 6);
  const auto good = [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; };
  if (out.empty() || out.size() > 200 || !std::all_of(out.begin(), out.end(), good)) wrong("has no token");
  return out;
}

Site read_site_file(const fs::path& file) {
  const Yaml root = Yaml::load(file.string());
  Problems problems;
  root.check_keys({"polyarm", "name", "cells"}, problems);
  if (root["polyarm"].text("") != "site/1")
    throw Error(
        Problem{"bad-site", root.where(), "this is no file of a site", "begin it with `polyarm: site/1`"});
  Site out;
  out.name = root["name"].text(fs::absolute(file).parent_path().filename().string());
  const Yaml cells = root.required("cells");
  const std::vector<std::string> names = cells.keys();
  if (names.empty() || names.size() > kMostCells)
    refuse(cells, "a site has 1 to " + std::to_string(kMostCells) + " cells",
           "cells: {press: {address: https://…, token_file: …}}");
  for (const std::string& name : names) {
    try {
      out.cells.push_back(read_cell(name, cells[name], file.parent_path(), problems));
    } catch (const Error& e) {
      problems.add(e);
    }
  }
  problems.throw_if_errors();
  return out;
}

}  // namespace polyarm::fleet
