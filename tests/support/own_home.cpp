/// Linked into each test program: it and all that it starts live in a home of their own, which is removed at
/// the end. Audit logs, known cells and caches of tests never reach those of a person.
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <string>

namespace {

class OwnHome {
 public:
  OwnHome() {
    char folder[] = "/tmp/polyarm_home_XXXXXX";  // short: addresses of sockets have at most 107 bytes
    if (!::mkdtemp(folder)) {
      std::perror("a home for tests");
      ::_exit(1);
    }
    folder_ = folder;
    owner_ = ::getpid();
    const auto set = [&](const char* name, const char* below) {
      const std::string path = folder_ + below;
      ::mkdir(path.c_str(), 0700);
      ::setenv(name, path.c_str(), 1);
    };
    set("HOME", "");
    set("XDG_RUNTIME_DIR", "/run");
    // Without them, folders below HOME are used, also that of a test that sets HOME itself.
    for (const char* name : {"XDG_DATA_HOME", "XDG_CONFIG_HOME", "XDG_STATE_HOME", "XDG_CACHE_HOME"})
      ::unsetenv(name);
  }
  ~OwnHome() {
    std::error_code ignored;
    if (::getpid() == owner_) std::filesystem::remove_all(folder_, ignored);
  }
  OwnHome(const OwnHome&) = delete;
  OwnHome& operator=(const OwnHome&) = delete;

 private:
  std::string folder_;
  pid_t owner_ = 0;
};

const OwnHome own_home;

}  // namespace
