// How fast programs calculate: loops, calls, arithmetic and lists, beside Lua 5.4 in the same run where it is
// installed, and what a tick of a program that never waits costs the cell thread. Of each workload the
// cheapest of some runs counts, and the ratio is the result; ticks are told whole. It says nothing about
// motion, data and tags, whose cost is the host's.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "polyarm/program/parser.hpp"
#include "tests/program/fake_host.hpp"
#ifdef POLYARM_LUA
#include <lua.hpp>
#endif

namespace polyarm::program {
namespace {

using Clock = std::chrono::steady_clock;

double microseconds(Clock::time_point begin) {
  return std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
}

struct Workload {
  const char* name;
  const char* ours;
  const char* lua;
};

const Workload kWorkloads[] = {
    {"loop", "let x = 0\nfor i in 1 .. 100000\n  set x = x + i\nend\n",
     "local x = 0\nfor i = 1, 100000 do x = x + i end\n"},
    {"while", "let x = 0\nwhile x < 100000\n  set x = x + 1\nend\n",
     "local x = 0\nwhile x < 100000 do x = x + 1 end\n"},
    {"arithmetic",
     "let x = 0.0\nfor i in 1 .. 50000\n  set x = (x * 3 + i / 7) mod 1000 - 2 * x / (i + 1)\nend\n",
     "local x = 0.0\nfor i = 1, 50000 do x = (x * 3 + i / 7) % 1000 - 2 * x / (i + 1) end\n"},
    {"units", "let x = 0mm\nfor i in 1 .. 50000\n  set x = x + 2mm * 3 - 5mm\nend\n",
     "local x = 0\nfor i = 1, 50000 do x = x + 0.002 * 3 - 0.005 end\n"},
    {"branches",
     "let n = 0\nfor i in 1 .. 50000\n  if i mod 3 == 0 and i mod 2 == 0\n    set n = n + 1\n  elif i mod 5 "
     "== 0\n"
     "    set n = n + 2\n  end\nend\n",
     "local n = 0\nfor i = 1, 50000 do if i % 3 == 0 and i % 2 == 0 then n = n + 1 elseif i % 5 == 0 then n "
     "= n + 2 "
     "end end\n"},
    {"calls",
     "func add(a, b)\n  return a + b\nend\nlet x = 0\nfor i in 1 .. 50000\n  set x = add(x, i)\nend\n",
     "local function add(a, b) return a + b end\nlocal x = 0\nfor i = 1, 50000 do x = add(x, i) end\n"},
    {"recursion",
     "func fib(n)\n  if n < 2\n    return n\n  end\n  return fib(n - 1) + fib(n - 2)\nend\nlet x = fib(20)\n",
     "local function fib(n) if n < 2 then return n end return fib(n - 1) + fib(n - 2) end\nlocal x = "
     "fib(20)\n"},
    {"lists",
     "let l = [1, 2, 3, 4, 5, 6, 7, 8]\nlet x = 0\nfor i in 1 .. 20000\n  set x = x + l[i mod 8 + 1]\nend\n",
     "local l = {1, 2, 3, 4, 5, 6, 7, 8}\nlocal x = 0\nfor i = 1, 20000 do x = x + l[i % 8 + 1] end\n"},
};

constexpr int kRuns = 15;

double ours(const char* text) {
  double best = 1e300;
  for (int run = 0; run < kRuns; ++run) {
    FakeHost host;
    Problems problems;
    Interpreter interpreter(parse(text, "bench.script", problems), host);
    problems.throw_if_errors();
    const auto begin = Clock::now();
    while (interpreter.state() == TaskState::running) interpreter.step(1000000);
    best = std::min(best, microseconds(begin));
    if (interpreter.state() != TaskState::finished) std::printf("%s did not finish\n", text);
  }
  return best;
}

#ifdef POLYARM_LUA
double lua(const char* text) {
  double best = 1e300;
  for (int run = 0; run < kRuns; ++run) {
    lua_State* state = luaL_newstate();
    luaL_openlibs(state);
    if (luaL_loadstring(state, text) != LUA_OK) std::printf("%s\n", lua_tostring(state, -1));
    const auto begin = Clock::now();
    if (lua_pcall(state, 0, 0, 0) != LUA_OK) std::printf("%s\n", lua_tostring(state, -1));
    best = std::min(best, microseconds(begin));
    lua_close(state);
  }
  return best;
}
#endif

/// Programs that never wait, as the cell steps them: the dearest tick is what counts.
void ticks() {
  std::printf("\n%-12s %10s %10s %10s   a tick of 200 statements, us\n", "never waits", "p50", "p99", "max");
  for (const Workload& work : kWorkloads) {
    FakeHost host;
    Problems problems;
    Interpreter interpreter(parse(work.ours, "bench.script", problems), host);
    std::vector<double> costs;
    while (interpreter.state() == TaskState::running && costs.size() < 20000) {
      const auto begin = Clock::now();
      interpreter.step(200);
      costs.push_back(microseconds(begin));
      host.time += 2'000'000;
    }
    std::sort(costs.begin(), costs.end());
    std::printf("%-12s %10.2f %10.2f %10.2f\n", work.name, costs[costs.size() / 2],
                costs[costs.size() * 99 / 100], costs.back());
  }
}

}  // namespace
}  // namespace polyarm::program

int main() {
  using namespace polyarm::program;
#ifdef POLYARM_LUA
  std::printf("%-12s %12s %12s %8s\n", "workload", "polyarm us", "lua 5.4 us", "ratio");
#else
  std::printf("%-12s %12s   (without Lua: find_package(Lua 5.4) found none)\n", "workload", "polyarm us");
#endif
  for (const Workload& work : kWorkloads) {
    const double mine = ours(work.ours);
#ifdef POLYARM_LUA
    const double peer = lua(work.lua);
    std::printf("%-12s %12.0f %12.0f %8.1f\n", work.name, mine, peer, mine / peer);
#else
    std::printf("%-12s %12.0f\n", work.name, mine);
#endif
  }
  ticks();
}
