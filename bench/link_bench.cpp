/// What a process of its own costs a link: each measurement once with the port in this process and once behind
/// RemotePort, in turn. Modbus: one round that writes one coil and reads four blocks of a server in a third process.
/// MQTT: from a publish to the tag, over a broker of this machine. And the processor time of an idle link, of both
/// processes. It cannot show what a loaded machine does: run it alone, or before others (chrt -f 10 link_bench).
///   link_bench [ROUNDS]
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "links/modbus/port.hpp"
#include "links/mqtt/port.hpp"
#include "polyarm/signals/remote_port.hpp"
#include "tests/links/running_link.hpp"

namespace polyarm {
namespace {

using Clock = std::chrono::steady_clock;
using signals::LinkEntry;
using signals::LinkReport;
using signals::LinkPort;
using signals::RemotePort;

double us_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
}

void report(const char* what, std::vector<double>& near, std::vector<double>& far) {
  std::sort(near.begin(), near.end());
  std::sort(far.begin(), far.end());
  const auto at = [](const std::vector<double>& all, double share) {
    return all[static_cast<std::size_t>(share * static_cast<double>(all.size() - 1))];
  };
  std::printf("%-28s in this process: p50 %7.1f p99 %7.1f max %8.1f us   own process: p50 %7.1f p99 %7.1f max %8.1f us\n",
              what, at(near, 0.5), at(near, 0.99), near.back(), at(far, 0.5), at(far, 0.99), far.back());
}

double processor_s(clockid_t clock) {
  timespec now{};
  return ::clock_gettime(clock, &now) == 0 ? static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec) : 0;
}
double processor_of(pid_t process) {
  clockid_t clock{};
  return ::clock_getcpuclockid(process, &clock) == 0 ? processor_s(clock) : 0;
}

std::string program(const char* kind) {
  return std::string(POLYARM_LINK_FOLDER) + "/" + signals::link_program(kind);
}

/// Rounds as Link makes them while nothing happens; the share of one processor, here and in the child.
void idle(const char* what, LinkPort& port, const RemotePort* remote, Nanoseconds poll) {
  const double here = processor_s(CLOCK_PROCESS_CPUTIME_ID), there = remote ? processor_of(remote->process()) : 0;
  const auto begin = Clock::now();
  while (us_since(begin) < 5e6) {
    LinkReport news;
    port.exchange({}, std::chrono::nanoseconds(Clock::now().time_since_epoch()).count(), 5'000'000, news);
    if (!port.waits()) std::this_thread::sleep_for(std::chrono::nanoseconds(poll));
  }
  const double seconds = us_since(begin) * 1e-6;
  std::printf("%-28s %s: %.2f %% of a processor here, %.2f %% there\n", what, remote ? "own process    " : "in this process",
              100 * (processor_s(CLOCK_PROCESS_CPUTIME_ID) - here) / seconds,
              remote ? 100 * (processor_of(remote->process()) - there) / seconds : 0.0);
}

void measure_modbus(int rounds) {
  const int port = test::free_port();
  const LinkEntry server = test::link_entry(
      "far: {modbus: server, port: PORT, tags: {A: {coil: 0, direction: in}, B: {holding: 0, direction: out}, C: {input: "
      "0}, D: {discrete: 5}}}",
      port);
  const pid_t plc = ::fork();
  if (plc == 0) {
    const auto far = polyarm::modbus::make_server(server);
    far->open();
    for (;;) {
      LinkReport news;
      far->exchange({}, 0, 5'000'000, news);
    }
  }
  while (!test::listens(port)) ::usleep(1000);
  const LinkEntry entry = test::link_entry(
      "plc: {modbus: client, port: PORT, poll: 50ms, tags: {A: {coil: 0, direction: both}, B: {holding: 0, direction: in}, "
      "C: {input: 0}, D: {discrete: 5}}}",
      port);
  const auto near = polyarm::modbus::make_client(entry);
  RemotePort far(entry, program("modbus"));
  near->open();
  far.open();
  std::vector<double> times[2];
  for (int i = 0; i < rounds; ++i)
    for (int turn = 0; turn < 2; ++turn) {
      const int k = (i + turn) % 2;
      LinkPort& each = k == 0 ? *near : static_cast<LinkPort&>(far);
      LinkReport news;
      const auto begin = Clock::now();
      each.exchange({{0, i % 2 == 0}}, i, 0, news);
      times[k].push_back(us_since(begin));
    }
  report("Modbus: write 1, read 4", times[0], times[1]);
  idle("Modbus client, poll 50 ms", *near, nullptr, 50'000'000);
  idle("Modbus client, poll 50 ms", far, &far, 50'000'000);
  ::kill(plc, SIGKILL);
  ::waitpid(plc, nullptr, 0);
}

void measure_mqtt(int rounds) {
  const int port = test::free_port();
  test::Peer broker(std::vector<std::string>{"/bin/sh", "-c", "exec /usr/sbin/mosquitto 2>/dev/null -p " + std::to_string(port)});
  test::eventually([&] { return test::listens(port); });
  const LinkEntry in = test::link_entry(
      "in: {mqtt: client, port: PORT, tags: {A: {topic: a, type: number, direction: in}}}", port);
  const LinkEntry out = test::link_entry(
      "out: {mqtt: client, port: PORT, tags: {A: {topic: a, type: number, direction: out, qos: 0}}}", port);
  const auto near = polyarm::mqtt::make_client(in);
  const auto sender = polyarm::mqtt::make_client(out);
  RemotePort far(in, program("mqtt"));
  near->open();
  far.open();
  sender->open();
  std::vector<double> times[2];
  for (int i = 0; i < rounds; ++i)
    for (int turn = 0; turn < 2; ++turn) {
      const int k = (i + turn) % 2;
      LinkPort& each = k == 0 ? *near : static_cast<LinkPort&>(far);
      LinkPort& other = k == 0 ? static_cast<LinkPort&>(far) : *near;
      LinkReport sent, news, rest;
      const auto begin = Clock::now();
      sender->exchange({{0, i}}, 0, 0, sent);
      while (news.values.empty()) each.exchange({}, 0, 5'000'000, news);
      times[k].push_back(us_since(begin));
      while (rest.values.empty()) other.exchange({}, 0, 5'000'000, rest);
    }
  report("MQTT: publish to tag", times[0], times[1]);
  idle("MQTT client", *near, nullptr, 0);
  idle("MQTT client", far, &far, 0);
}

}  // namespace
}  // namespace polyarm

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 5000;
  ::signal(SIGPIPE, SIG_IGN);
  polyarm::measure_modbus(rounds);
  if (polyarm::test::has_mosquitto()) polyarm::measure_mqtt(rounds);
}
