// How fast programs calculate: loops, calls, arithmetic, lists, records and texts, beside Lua 5.4 in the same
// run where it is installed, and what a tick of a program that never waits costs the cell thread, also where
// its lines are long and its lists as large as they may be. Of each workload the cheapest of some runs
// counts, and the ratio is the result; ticks are told whole, and by the least that each of them took in seven
// rounds, which leaves out what interrupted the machine. It says nothing about motion, data and tags,
// whose cost is the host's.
#include <malloc.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "polyarm/language/parser.hpp"
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

/// Of this thread, in microseconds.
double processor_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e6 + static_cast<double>(now.tv_nsec) * 1e-3;
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
    {"list parts",
     "let l = [1, 2, 3, 4, 5, 6, 7, 8]\nfor i in 1 .. 20000\n  set l[i mod 8 + 1] = l[1] + i\nend\n",
     "local l = {1, 2, 3, 4, 5, 6, 7, 8}\nfor i = 1, 20000 do l[i % 8 + 1] = l[1] + i end\n"},
    {"list grows", "let l = []\nfor i in 1 .. 9000\n  set l = l + [i]\nend\n",
     "local l = {}\nfor i = 1, 9000 do l[#l + 1] = i end\n"},
    {"for each",
     "let l = [1, 2, 3, 4, 5, 6, 7, 8]\nlet x = 0\nfor i in 1 .. 2500\n  for v in l\n    set x = x + v\n  "
     "end\n"
     "end\n",
     "local l = {1, 2, 3, 4, 5, 6, 7, 8}\nlocal x = 0\nfor i = 1, 2500 do for _, v in ipairs(l) do x = x + v "
     "end "
     "end\n"},
    {"matrix",
     "let m = [[1, 2, 3], [4, 5, 6], [7, 8, 9]]\nlet x = 0\nfor i in 1 .. 5000\n  for j in 1 .. 3\n    set "
     "m[j][1] = m[j][2] + m[j][3] mod 7\n    set x = x + m[j][1]\n  end\nend\n",
     "local m = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}\nlocal x = 0\nfor i = 1, 5000 do for j = 1, 3 do m[j][1] = "
     "m[j][2] + m[j][3] % 7 x = x + m[j][1] end end\n"},
    {"sorting",
     "let l = []\nfor i in 1 .. 120\n  set l = l + [i * 37 mod 101]\nend\nfor i in 1 .. 119\n  for j in 1 .. "
     "120 - i\n    if l[j] > l[j + 1]\n      let t = l[j]\n      set l[j] = l[j + 1]\n      set l[j + 1] = "
     "t\n    end\n  end\nend\n",
     "local l = {}\nfor i = 1, 120 do l[#l + 1] = i * 37 % 101 end\nfor i = 1, 119 do for j = 1, 120 - i do "
     "if l[j] > l[j + 1] then local t = l[j] l[j] = l[j + 1] l[j + 1] = t end end end\n"},
    {"choices",
     "let kind = \"red\"\nlet n = 0\nlet full = false\nfor i in 1 .. 20000\n  if kind == \"blue\" or full\n  "
     "  set n = n + 2\n  elif kind == \"red\" and not full\n    set n = n + 1\n  end\n  set full = n mod 5 "
     "== 4\nend\n",
     "local kind = 'red'\nlocal n = 0\nlocal full = false\nfor i = 1, 20000 do if kind == 'blue' or full "
     "then n = n + 2 elseif kind == 'red' and not full then n = n + 1 end full = n % 5 == 4 end\n"},
    {"parts",
     "let parts = [{x = 1, w = 2}, {x = 3, w = 4}, {x = 5, w = 6}]\nfunc weight(p, scale = 2)\n  return p.x "
     "* p.w * scale\nend\nlet s = 0\nfor i in 1 .. 5000\n  for p in parts\n    set s = s + weight(p)\n  "
     "end\nend\n",
     "local parts = {{x = 1, w = 2}, {x = 3, w = 4}, {x = 5, w = 6}}\nlocal function weight(p, scale) scale "
     "= scale or 2 return p.x * p.w * scale end\nlocal s = 0\nfor i = 1, 5000 do for _, p in ipairs(parts) "
     "do s = s + weight(p) end end\n"},
    {"new records", "let r = {x = 0, y = 1}\nfor i in 1 .. 10000\n  set r = {x = i, y = r.x}\nend\n",
     "local r = {x = 0, y = 1}\nfor i = 1, 10000 do r = {x = i, y = r.x} end\n"},
    {"records", "let r = {x = 0, y = 1}\nfor i in 1 .. 20000\n  set r.x = r.x + r.y\nend\n",
     "local r = {x = 0, y = 1}\nfor i = 1, 20000 do r.x = r.x + r.y end\n"},
    {"texts", "let t = \"\"\nfor i in 1 .. 20000\n  set t = \"part {i} of {20000}\"\nend\n",
     "local t = ''\nfor i = 1, 20000 do t = 'part ' .. i .. ' of ' .. 20000 end\n"},
    {"text grows", "let t = \"\"\nfor i in 1 .. 9000\n  set t = t + \"x\"\nend\n",
     "local t = ''\nfor i = 1, 9000 do t = t .. 'x' end\n"},
    {"maths", "let x = 0\nfor i in 1 .. 20000\n  set x = x + floor(abs(x - i) / 2)\nend\n",
     "local x = 0\nfor i = 1, 20000 do x = x + math.floor(math.abs(x - i) / 2) end\n"},
};

/// What may take long in one statement.
const Workload kLarge[] = {
    {"long lines", nullptr, ""},
    {"list sums",
     "let l = []\nfor i in 1 .. 4900\n  set l = l + [i]\nend\nlet k = l\nwhile true\n  set k = l + l\nend\n",
     ""},
    {"list copies",
     "let l = []\nfor i in 1 .. 9990\n  set l = l + [i]\nend\nlet k = l\nwhile true\n  set k = l\n  set k[1] "
     "= "
     "2\nend\n",
     ""},
    {"compares",
     "let l = []\nfor i in 1 .. 9990\n  set l = l + [i]\nend\nlet k = l + []\nlet n = 0\nwhile true\n  if l "
     "== k\n"
     "    set n = n + 1\n  end\nend\n",
     ""},
    {"points copied",
     "let l = pallet(pose(), pose(x = 1m), pose(y = 1m), rows = 100, cols = 99)\nlet k = l\nwhile true\n  "
     "set k = l\n  set k[1] = pose()\nend\n",
     ""},
    {"pallets",
     "let l = []\nwhile true\n  set l = pallet(pose(), pose(x = 1m), pose(y = 1m), rows = 100, cols = "
     "100)\nend\n",
     ""},
    {"texts let go",
     "let l = []\nwhile true\n  set l = []\n  for i in 1 .. 9000\n    set l = l + [\"a part of the list, "
     "number {i}\"]\n  end\nend\n",
     ""},
    {"deep calls",
     "func deep(n)\n  if n == 0\n    return 0\n  end\n  return 1 + deep(n - 1)\nend\nlet x = 0\nwhile true\n "
     " set x = deep(190)\nend\n",
     ""},
    {"errors",
     "let l = []\nfor i in 1 .. 9000\n  set l = l + [i]\nend\nlet n = 0\nwhile true\n  try\n    set n = l\n  "
     "on error e\n    set n = n + 1\n  end\nend\n",
     ""},
    {"lists told",
     "let l = []\nfor i in 1 .. 9000\n  set l = l + [i]\nend\nlet t = \"\"\nwhile true\n  set t = \"{l}\"\n"
     "end\n",
     ""},
    {"large texts",
     "let s = \"x\"\nfor i in 1 .. 15\n  set s = s + s\nend\nlet t = s\nwhile true\n  set t = s + s\nend\n",
     ""},
    {"functions",
     "let x = 0\nwhile true\n  set x = sin(1rad) + cos(2rad) + tan(1rad) + sqrt(2) + abs(x) + "
     "floor(x)\nend\n",
     ""},
};

std::string long_line() {
  std::string line = "  set x = 1";
  for (int i = 0; i < 140; ++i) line += " + x * 2 - x";
  return "let x = 0\nwhile true\n" + line + "\n  set x = 0\nend\n";
}

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

/// What each tick of a program that never waits costs, as the cell steps it.
std::vector<double> costs_of(const std::string& text) {
  constexpr int kBudget = 200;  // of the cell
  constexpr std::size_t kMostTicks = 5000;
  FakeHost host;
  Problems problems;
  Interpreter interpreter(parse(text, "bench.script", problems), host);
  problems.throw_if_errors();
  std::vector<double> costs;
  while (interpreter.state() == TaskState::running && costs.size() < kMostTicks) {
    const double begin = processor_time();
    interpreter.step(kBudget);
    costs.push_back(processor_time() - begin);
    host.time += 2'000'000;
  }
  return costs;
}

void print_costs(std::vector<double> costs) {
  std::sort(costs.begin(), costs.end());
  const auto slow = std::lower_bound(costs.begin(), costs.end(), 50.0);
  std::printf(" %8.2f %8.2f %8.2f %5td", costs[costs.size() / 2], costs[costs.size() * 99 / 100],
              costs.back(), costs.end() - slow);
}

/// The same program does the same in the same tick: what only some rounds show is the machine's.
void ticks(const char* name, const std::string& text) {
  constexpr int kRounds = 7;
  std::vector<double> least = costs_of(text);
  std::printf("%-13s %6zu", name, least.size());
  print_costs(least);
  for (int round = 1; round < kRounds; ++round) {
    const std::vector<double> costs = costs_of(text);
    for (std::size_t i = 0; i < std::min(costs.size(), least.size()); ++i)
      least[i] = std::min(least[i], costs[i]);
  }
  print_costs(least);
  std::printf("\n");
}

}  // namespace
}  // namespace polyarm::program

int main() {
  mallopt(M_MXFAST, 0);  // as the command does
  using namespace polyarm::program;
#ifdef POLYARM_LUA
  std::printf("%-13s %12s %12s %8s\n", "workload", "polyarm us", "lua 5.4 us", "ratio");
#else
  std::printf("%-13s %12s   (without Lua: find_package(Lua 5.4) found none)\n", "workload", "polyarm us");
#endif
  for (const Workload& work : kWorkloads) {
    const double mine = ours(work.ours);
#ifdef POLYARM_LUA
    const double peer = lua(work.lua);
    std::printf("%-13s %12.0f %12.0f %8.1f\n", work.name, mine, peer, mine / peer);
#else
    std::printf("%-13s %12.0f\n", work.name, mine);
#endif
  }
  std::printf("\na tick of 200 statements, us of processor time: one round; of seven, each tick's least\n");
  std::printf("%-13s %6s %8s %8s %8s %5s %8s %8s %8s %5s\n", "never waits", "ticks", "p50", "p99", "max",
              ">50", "p50", "p99", "max", ">50");
  for (const Workload& work : kWorkloads) ticks(work.name, work.ours);
  for (const Workload& work : kLarge) ticks(work.name, work.ours ? work.ours : long_line());
}
