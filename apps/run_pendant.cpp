#include "apps/run_pendant.hpp"

#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef POLYARM_QRENCODE
#include <qrencode.h>
#endif

#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "apps/picture.hpp"
#include "polyarm/cell/socket_door.hpp"
#include "polyarm/server/token.hpp"

namespace polyarm::apps {

namespace {

namespace fs = std::filesystem;

constexpr int kPort = 8765;

/// The token of this user's pendants: in the folder of the local sockets, which is the user's alone.
std::string token_of_user() {
  const fs::path folder = cell::SocketDoor::folder_of_user();
  std::error_code error;
  fs::create_directories(folder, error);
  fs::permissions(folder, fs::perms::owner_all, error);
  return server::kept_token(folder / "pendant.token");
}

/// The robot with its joints in the middle of what a picture shows: home where it is known.
std::string picture(const description::RobotModel& model) {
  std::vector<double> q(model.actuated.size(), 0.0);
  const auto home = model.named_states.find("home");
  if (home != model.named_states.end() && home->second.size() == q.size()) q = home->second;
  return picture_of(model, q);
}

void open_in_browser(const std::string& link) {
  const pid_t child = ::fork();
  if (child == 0) {
    if (::fork() == 0) ::execlp("xdg-open", "xdg-open", link.c_str(), nullptr);
    ::_exit(0);
  }
  if (child > 0) ::waitpid(child, nullptr, 0);
}

/// The link as a QR code in half blocks, dark on light; nothing where the command was built without.
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
    std::string line = "\033[30;47m";
    for (int x = -kQuiet; x < code->width + kQuiet; ++x)
      line += dark(x, y) ? (dark(x, y + 1) ? "█" : "▀") : dark(x, y + 1) ? "▄" : " ";
    std::printf("%s\033[0m\n", line.c_str());
  }
  std::fflush(stdout);
#endif
}

}  // namespace

void add_pendant_options(CommandLine& app, PendantArguments& a) {
  app.add_flag("--pendant", a.on, "serve the pendant to a browser on this machine, and print its link");
  app.add_option("--port", a.port, "of the pendant; 0: any that is free. Not stated: 8765, or another")
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
  app.add_flag("--open", a.open, "open the pendant in the browser");
}

std::unique_ptr<server::Pendant> open_pendant(const PendantArguments& a,
                                              const description::Catalogue& catalogue, cell::Observer& next) {
  server::PendantOptions options;
  options.port = static_cast<std::uint16_t>(a.port < 0 ? kPort : a.port);
  if (a.listens) options.listen = a.listen;
  options.token = token_of_user();
  if (const char* page = std::getenv("POLYARM_PENDANT_PAGE")) options.page_folder = page;
  options.version = POLYARM_VERSION;
  options.catalogue = &catalogue;
  options.picture = picture;
  try {
    return std::make_unique<server::Pendant>(options, next);
  } catch (const Error&) {
    if (a.port >= 0) throw;
  }
  options.port = 0;  // another cell has it
  return std::make_unique<server::Pendant>(std::move(options), next);
}

void announce(const server::Pendant& pendant, const PendantArguments& a, cell::Observer& observer) {
  if (const std::string link = pendant.outside_link(); !link.empty()) {
    observer.on_note("pendant on other machines: " + link);
    if (::isatty(STDOUT_FILENO) != 0) print_code(link);
  }
  if (a.open) open_in_browser(pendant.link());
}

}  // namespace polyarm::apps
