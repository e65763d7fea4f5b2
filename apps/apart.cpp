#include "apps/apart.hpp"

#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <thread>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {
using Clock = std::chrono::steady_clock;

struct Running {
  std::size_t which = 0;
  pid_t process = 0;
  int pipe = -1;
  std::string said;
  Clock::time_point begun;
  bool too_long = false;
};

double since(Clock::time_point begun) {
  return std::chrono::duration<double>(Clock::now() - begun).count();
}

void write_all(int pipe, const std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t n = ::write(pipe, text.data() + at, text.size() - at);
    if (n <= 0 && errno != EINTR) return;
    if (n > 0) at += static_cast<std::size_t>(n);
  }
}

/// A job ends with its parent, even if that is killed; Ctrl-C is the parent's to answer.
void follow(pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
  ::signal(SIGINT, SIG_IGN);
  ::signal(SIGTERM, SIG_DFL);
}

Running begin(std::size_t which, const std::function<std::string(std::size_t)>& job, bool follows) {
  int ends[2];
  if (::pipe(ends) != 0) throw Error("no-process", std::string("no pipe: ") + std::strerror(errno));
  std::fflush(nullptr);
  const pid_t parent = ::getpid(), process = ::fork();
  if (process < 0) throw Error("no-process", std::string("no process: ") + std::strerror(errno));
  if (process == 0) {
    ::close(ends[0]);
    if (follows) follow(parent);
    int code = 0;
    try {
      write_all(ends[1], job(which));
    } catch (...) {
      code = 1;
      std::fprintf(stderr, "%s\n", what_was_thrown().c_str());
    }
    ::_exit(code);
  }
  ::close(ends[1]);
  return {which, process, ends[0], {}, Clock::now(), false};
}

ApartResult end(Running& job, double patience) {
  ::close(job.pipe);
  int status = 0;
  while (::waitpid(job.process, &status, 0) < 0 && errno == EINTR) {
  }
  ApartResult out;
  out.seconds = since(job.begun);
  if (job.too_long) {
    out.why = "it took more than " + format_number(patience) + " s";
  } else if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    out.why = std::string("it crashed: ") + ::strsignal(signal);
    out.from_outside = signal == SIGINT || signal == SIGTERM || signal == SIGHUP || signal == SIGKILL;
  } else if (WEXITSTATUS(status) != 0) {
    out.why = "it ended with an unexpected error";
  } else {
    out.said = std::move(job.said);
  }
  return out;
}

/// True when the pipe was closed.
bool read_some(Running& job) {
  char text[4096];
  const ssize_t n = ::read(job.pipe, text, sizeof text);
  if (n > 0) job.said.append(text, static_cast<std::size_t>(n));
  return n == 0 || (n < 0 && errno != EINTR);
}
}  // namespace

unsigned processors() {
  return std::max(1u, std::thread::hardware_concurrency());
}

namespace {
using Next = std::function<std::optional<std::size_t>()>;

void end_all(std::vector<Running>& running) {
  for (Running& each : running) ::kill(each.process, SIGKILL);
  for (Running& each : running) end(each, 0);
  running.clear();
}

void run_each(const Next& next, unsigned most, double patience,
              const std::function<std::string(std::size_t)>& job,
              const std::function<void(std::size_t, const ApartResult&)>& done,
              const std::function<bool()>& given_up) {
  std::vector<Running> running;
  std::optional<std::size_t> which = next();
  while (which || !running.empty()) {
    for (; which && running.size() < std::max(1u, most); which = next())
      running.push_back(begin(*which, job, given_up != nullptr));
    std::vector<pollfd> waits;
    for (const Running& each : running) waits.push_back({each.pipe, POLLIN, 0});
    ::poll(waits.data(), waits.size(), 200);
    if (given_up && given_up()) return end_all(running);
    for (std::size_t i = running.size(); i-- > 0;) {
      Running& each = running[i];
      if (!each.too_long && since(each.begun) > patience) {
        each.too_long = true;
        ::kill(each.process, SIGKILL);
      }
      if (waits[i].revents == 0 || !read_some(each)) continue;
      done(each.which, end(each, patience));
      running.erase(running.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }
}
}  // namespace

void run_apart(std::size_t count, unsigned most, double patience,
               const std::function<std::string(std::size_t)>& job,
               const std::function<void(std::size_t, const ApartResult&)>& done) {
  const Next next = [count, i = std::size_t{0}]() mutable {
    return i < count ? std::optional(i++) : std::nullopt;
  };
  run_each(next, most, patience, job, done, nullptr);
}

void run_apart(const Next& next, unsigned most, double patience,
               const std::function<std::string(std::size_t)>& job,
               const std::function<void(std::size_t, const ApartResult&)>& done,
               const std::function<bool()>& given_up) {
  run_each(next, most, patience, job, done, given_up);
}

}  // namespace polyarm::apps
