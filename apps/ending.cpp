#include "apps/ending.hpp"

#include <fcntl.h>
#include <poll.h>
#include <semaphore.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <string_view>
#include <thread>

#include "apps/options.hpp"
#include "polyarm/cell/run.hpp"

namespace polyarm::apps {

namespace {

std::atomic<bool> simulated{true};
sem_t terminated;  // posted by SIGTERM

/// The first signal stops on the path, the second at once, the third ends the process.
void on_request(int number) {
  if (cell::stops_requested() >= 2) {
    ::signal(number, SIG_DFL);
    ::raise(number);
  }
  cell::request_stop();
  if (number == SIGTERM) ::sem_post(&terminated);
}

void on_loss(int) {
  cell::request_stop_once();
}

void on_suspend(int) {
  cell::request_hold();
}

constexpr std::array kFaults{SIGILL, SIGABRT, SIGBUS, SIGFPE, SIGSEGV, SIGSYS};
std::array<struct sigaction, kFaults.size()> faults_before;

/// If another process sent the signal, the first one stops on the path. Faults of this process itself end it
/// at once, because its state is unknown then.
void on_fault(int number, siginfo_t* info, void*) {
  const int error = errno;
  for (std::size_t i = 0; i < kFaults.size(); ++i)
    if (kFaults[i] == number) ::sigaction(number, &faults_before[i], nullptr);
  const bool sent = info->si_code <= 0, faulty_instruction = !sent && number != SIGSYS;
  if (sent && info->si_pid != ::getpid())
    cell::request_stop_once();
  else if (!faulty_instruction)  // a faulty instruction runs again after this function
    ::raise(number);
  errno = error;
}

void catch_faults() {
  struct sigaction action {};
  action.sa_sigaction = on_fault;
  action.sa_flags = SA_SIGINFO;
  for (std::size_t i = 0; i < kFaults.size(); ++i) ::sigaction(kFaults[i], &action, &faults_before[i]);
}

void catch_signal(int number, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  ::sigaction(number, &action, nullptr);
}

/// True for signals without a special meaning here. They end the run on the path.
bool would_end_the_process(int number) {
  for (const int other : {SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGPIPE, SIGXFSZ,             // caught or ignored
                          SIGCHLD, SIGURG, SIGWINCH, SIGCONT,                             // do not end it
                          SIGSTOP, SIGTSTP, SIGTTIN, SIGTTOU, SIGKILL,                    // suspend or kill
                          SIGILL, SIGABRT, SIGBUS, SIGFPE, SIGSEGV, SIGSYS})              // on_fault()
    if (number == other) return false;
  return true;
}

/// A simulated cell moves nothing real, so it may be ended while a build, a check or a plugin does not react.
void end_in_time() {
  constexpr auto kOnThePath = std::chrono::milliseconds(500), kAtOnce = std::chrono::milliseconds(350);
  while (::sem_wait(&terminated) != 0 && errno == EINTR) {
  }
  std::this_thread::sleep_for(kOnThePath);
  if (!simulated) return;
  cell::request_stop();
  std::this_thread::sleep_for(kAtOnce);
  if (!simulated) return;
  constexpr std::string_view kText = "polyarm: a simulated cell was ended on SIGTERM before it was done\n";
  pollfd room{STDERR_FILENO, POLLOUT, 0};  // a reader that does not read would block this thread
  if (::poll(&room, 1, 0) == 1 && (room.revents & POLLOUT) != 0 &&
      ::write(STDERR_FILENO, kText.data(), kText.size()) < 0) {  // nobody reads the message
  }
  ::_exit(kStopped);
}

}  // namespace

void stop_on_signals(bool wall_clock) {
  ::sem_init(&terminated, 0, 0);
  for (const int number : {SIGINT, SIGTERM, SIGQUIT}) catch_signal(number, on_request);
  struct sigaction before {};
  ::sigaction(SIGHUP, nullptr, &before);
  if (before.sa_handler != SIG_IGN) catch_signal(SIGHUP, on_loss);
  for (int number = 1; number <= SIGRTMAX; ++number)
    if (would_end_the_process(number)) catch_signal(number, on_loss);
  for (const int number : {SIGPIPE, SIGXFSZ}) catch_signal(number, SIG_IGN);
  catch_faults();
  if (wall_clock) {
    catch_signal(SIGTSTP, on_suspend);
    for (const int number : {SIGTTIN, SIGTTOU}) catch_signal(number, SIG_IGN);
  }
  std::thread(end_in_time).detach();
}

void set_simulated(bool is) {
  simulated = is;
}

void write_to_nowhere() noexcept {
  const int error = errno;
  if (const int nobody = ::open("/dev/null", O_WRONLY | O_CLOEXEC); nobody >= 0) {
    ::dup2(nobody, STDOUT_FILENO);
    ::close(nobody);
  }
  errno = error;
}

}  // namespace polyarm::apps
