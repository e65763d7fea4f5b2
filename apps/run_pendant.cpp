#include "apps/run_pendant.hpp"

#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef POLYARM_QRENCODE
#include <qrencode.h>
#endif

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "apps/picture.hpp"
#include "apps/terminal.hpp"
#include "polyarm/access/tls.hpp"
#include "polyarm/access/token.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/socket_door.hpp"
#include "polyarm/users/user_list.hpp"

namespace polyarm::apps {

namespace {

namespace fs = std::filesystem;

constexpr int kPort = 8765;

/// The token of this user's pendants, stored in the private folder of the local sockets.
std::string token_of_user() {
  return server::kept_token(cell::SocketDoor::own_folder() / "pendant.token");
}

/// The robot in its start state, usually home.
std::string picture(const description::RobotModel& model) {
  return picture_of(model, model.start());
}

/// Opens a private page that redirects to the link, because everybody can read the token in a command line.
void open_in_browser(const std::string& target) {
  const fs::path page = cell::SocketDoor::own_folder() / "open.html";
  const AsUser user;
  write_file_atomically(page,
                        "<!doctype html><meta charset=utf-8><meta name=referrer content=no-referrer>"
                        "<meta http-equiv=refresh content=\"0;url=" +
                            target + "\"><title>Polyarm</title>\n",
                        0600);
  const std::string link = page.string();
  const pid_t child = ::fork();
  if (child == 0) {
    if (::fork() == 0) ::execlp("xdg-open", "xdg-open", link.c_str(), nullptr);
    ::_exit(0);
  }
  if (child > 0) ::waitpid(child, nullptr, 0);
}

/// Prints the link as a QR code in half blocks, dark on light; does nothing if built without QR support.
void print_code(const std::string& link) {
#ifdef POLYARM_QRENCODE
  const std::unique_ptr<QRcode, decltype(&QRcode_free)> code(
      QRcode_encodeString(link.c_str(), 0, QR_ECLEVEL_L, QR_MODE_8, 1), &QRcode_free);
  if (!code) return;
  constexpr int kQuiet = 2;
  const auto dark = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < code->width && y < code->width &&
           (code->data[y * code->width + x] & 1) != 0;
  };
  for (int y = -kQuiet; y < code->width + kQuiet; y += 2) {
    std::string line = own_escape("[30;47m");
    for (int x = -kQuiet; x < code->width + kQuiet; ++x)
      line += dark(x, y) ? (dark(x, y + 1) ? "█" : "▀") : dark(x, y + 1) ? "▄" : " ";
    fmt::print("{}{}\n", line, own_escape("[0m"));
  }
  std::fflush(stdout);
#endif
}

}  // namespace

void add_pendant_options(CommandLine& app, PendantArguments& a) {
  app.add_flag("--pendant", a.on, "serve the pendant to a browser on this machine, and print its link");
  app.add_option("--port", a.port,
                 "port of the pendant; 0: any free port. Default: 8765, or another one if that is in use")
      ->range(0, 65535);
  app.add_option_function(
         "--listen",
         [&a](const std::string& address) {
           a.listens = a.on = true;
           a.listen = address;
         },
         "other machines may open the pendant, too: on all addresses of this one, or on ADDR")
      ->expected(0, 1)
      ->type_name("[ADDR]");
  app.add_option("--certificate", a.certificate,
                 "PEM file with the certificate for other machines; default: one created for this user");
  app.add_option("--key", a.key, "PEM file with its key");
  app.add_flag(
      "--in-clear", a.in_clear,
      "serve other machines without TLS: anyone on the network can read the token and move the robot");
  app.add_option("--log-in-hours", a.log_in_hours, "every log-in of a user ends after so many hours (12)")
      ->range(0.001, 720.0);
  app.add_flag("--role-links", a.links, "print a link for each role: watch, operate, program, administer");
  app.add_option_function(
         "--metrics",
         [&a](const std::string& where) {
           a.on = true;
           a.metrics = where.empty() ? "9464" : where;
         },
         "serve GET /metrics for Prometheus on this port of the loopback interface (9464), or on ADDR:PORT")
      ->expected(0, 1)
      ->type_name("[[ADDR:]PORT]");
  app.add_flag("--open", a.open, "open the pendant in the browser");
}

namespace {

/// A folder for user data that survives a restart of the machine.
fs::path data_of_user() {
  const fs::path folder = users::folder_of_user();
  return folder.empty() ? cell::SocketDoor::folder_of_user() : folder;
}

server::PendantOptions::Metrics metrics_of(const std::string& where) {
  server::PendantOptions::Metrics out;
  const auto colon = where.rfind(':');
  if (colon != std::string::npos) out.address = where.substr(0, colon);
  const std::string port = colon == std::string::npos ? where : where.substr(colon + 1);
  const auto number = parse_number(port);
  if (out.address.empty() || !number || *number < 0 || *number > 65535 ||
      *number != static_cast<int>(*number))
    throw Error("bad-option", "--metrics " + where + " is no port",
                "for example --metrics 9464, or --metrics 0.0.0.0:9464");
  out.port = static_cast<std::uint16_t>(*number);
  return out;
}

std::optional<server::Certificate> certificate_of(const PendantArguments& a) {
  const bool named = !a.certificate.empty() || !a.key.empty();
  if (named && (a.certificate.empty() || a.key.empty()))
    throw Error("bad-option", "--certificate and --key belong together", "state both");
  if (named && a.in_clear) throw Error("bad-option", "--in-clear uses no certificate", "state one of them");
  if (!a.listens || a.in_clear) return std::nullopt;
  if (named) return server::read_certificate(a.certificate, a.key);
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  return server::kept_certificate(data_of_user(), host.data());
}

}  // namespace

std::unique_ptr<server::Pendant> open_pendant(const PendantArguments& a,
                                              const description::Catalogue& catalogue, cell::Observer& next,
                                              users::AuditLog* audit) {
  server::PendantOptions options;
  options.port = static_cast<std::uint16_t>(a.port < 0 ? kPort : a.port);
  if (a.listens) options.listen = a.listen;
  if (const auto certificate = certificate_of(a)) {
    options.certificate = certificate->chain;
    options.key = certificate->key;
    options.fingerprint = certificate->fingerprint;
  }
  options.token = token_of_user();
  options.log_in_hours = a.log_in_hours;
  options.users = users::users_file(data_of_user());
  options.audit = audit;
  if (!a.metrics.empty()) options.metrics = metrics_of(a.metrics);
  if (const char* page = std::getenv("POLYARM_PENDANT_PAGE")) options.page_folder = page;
  options.version = POLYARM_VERSION;
  options.catalogue = &catalogue;
  options.picture = picture;
  try {
    return std::make_unique<server::Pendant>(options, next);
  } catch (const Error&) {
    if (a.port >= 0 || options.metrics) throw;
  }
  options.port = 0;  // another cell uses the port
  return std::make_unique<server::Pendant>(std::move(options), next);
}

void announce(const server::Pendant& pendant, const PendantArguments& a, cell::Observer& observer) {
  const std::string link = pendant.outside_link();  // empty: the machine has no network yet
  if (!link.empty()) observer.on_note("pendant on other machines: " + link);
  if (!link.empty() && a.in_clear)
    observer.on_note(
        "warning: --in-clear: nothing is encrypted; anyone on the network can read the token and move the "
        "robot");
  if (!pendant.fingerprint().empty())
    observer.on_note("its certificate, which the browser shows as SHA-256: " + pendant.fingerprint());
  if (!link.empty()) {
    observer.on_note("to watch alone: " + pendant.link_for(protocol::Role::watch));
    if (::isatty(STDOUT_FILENO) != 0) print_code(link);
  }
  if (a.links)
    for (const protocol::Role role : {protocol::Role::watch, protocol::Role::operate, protocol::Role::program,
                                      protocol::Role::administer})
      observer.on_note(std::string("link to ") + protocol::name(role) + ": " + pendant.link_for(role));
  if (pendant.metrics_port() != 0)
    observer.on_note("metrics for Prometheus: port " + std::to_string(pendant.metrics_port()) +
                     ", path /metrics");
  if (a.open) open_in_browser(pendant.link());
}

}  // namespace polyarm::apps
