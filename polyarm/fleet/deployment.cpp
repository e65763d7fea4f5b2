#include "polyarm/fleet/deployment.hpp"

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/fleet/cell_client.hpp"

namespace polyarm::fleet {

using Json = nlohmann::json;

namespace {

constexpr std::size_t kMostCompared = bounds::kSiteLinePairs;  // pairs of lines
constexpr std::size_t kMostProblems = bounds::kSiteProblems;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    out.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return out;
}

std::string text_at(const Json& map, const char* key) {
  return map.is_object() && map.contains(key) && map[key].is_string() ? map[key].get<std::string>()
                                                                      : std::string();
}

/// One thread for each cell.
void each_at_once(std::size_t count, const std::function<void(std::size_t)>& work) {
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < count; ++i) threads.emplace_back([&work, i] { work(i); });
  for (std::thread& each : threads) each.join();
}

void guarded(Deployed& out, const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& e) {
    out.state = Deployed::State::refused;
    out.why = printable_line(e.problems().front().code + ": " + e.problems().front().what);
  } catch (const std::exception& e) {
    out.state = Deployed::State::refused;
    out.why = printable_line(e.what());
  }
}

/// The text that the cell has; empty if it has no such file.
std::string read_present(CellClient& client, const std::string& file, std::string& hash) {
  const Json list = client.ask({{"request", "files"}});
  const Json files = list.is_object() && list.contains("files") ? list["files"] : Json::array();
  const bool there = std::any_of(files.begin(), files.end(),
                                 [&](const Json& each) { return text_at(each, "name") == file; });
  if (!there) return {};
  const Json read = client.ask({{"request", "files.read"}, {"name", file}});
  hash = text_at(read, "hash");
  return text_at(read, "text");
}

void plan_one(CellClient& client, const std::string& file, const std::string& text, Deployed& out) {
  const std::string before = read_present(client, file, out.base);
  out.diff = difference(before, text);
  const Json checked = client.ask({{"request", "program.check"}, {"name", file}, {"text", text}});
  bool errors = false;
  if (!checked.is_object() || !checked.contains("problems") || !checked["problems"].is_array())
    throw Error("refused", "the answer of its check has no list of problems");
  for (const Json& each : checked["problems"]) {
    if (!each.is_object()) continue;
    errors = errors || text_at(each, "severity") != "warning";
    if (out.problems.size() < kMostProblems)
      out.problems.push_back(
          printable_line(text_at(each, "severity") + ": " + text_at(each, "what") +
                         (each.contains("line") ? " (line " + each["line"].dump() + ")" : "")));
  }
  const bool same = before == text && !out.base.empty();
  out.state = errors ? Deployed::State::faulty : same ? Deployed::State::same : Deployed::State::ready;
}

}  // namespace

const char* name(Deployed::State state) {
  constexpr const char* kNames[] = {"same", "ready", "written", "faulty", "refused"};
  return kNames[static_cast<std::size_t>(state)];
}

std::vector<std::string> difference(const std::string& before, const std::string& after, std::size_t most) {
  std::vector<std::string> a = lines_of(before), b = lines_of(after);
  while (!a.empty() && !b.empty() && a.back() == b.back()) a.pop_back(), b.pop_back();
  std::size_t start = 0;
  while (start < a.size() && start < b.size() && a[start] == b[start]) ++start;
  a.erase(a.begin(), a.begin() + static_cast<std::ptrdiff_t>(start));
  b.erase(b.begin(), b.begin() + static_cast<std::ptrdiff_t>(start));
  std::vector<std::string> out;
  const std::size_t n = a.size(), m = b.size();
  if (n * m > kMostCompared) {  // too long to compare: all of it is replaced
    for (const std::string& line : a) out.push_back("-" + line);
    for (const std::string& line : b) out.push_back("+" + line);
  } else {
    // Length of the longest common part of the rest, by position.
    std::vector<std::vector<std::uint32_t>> common(n + 1, std::vector<std::uint32_t>(m + 1, 0));
    for (std::size_t i = n; i-- > 0;)
      for (std::size_t j = m; j-- > 0;)
        common[i][j] = a[i] == b[j] ? common[i + 1][j + 1] + 1 : std::max(common[i + 1][j], common[i][j + 1]);
    for (std::size_t i = 0, j = 0; i < n || j < m;) {
      if (i < n && j < m && a[i] == b[j])
        ++i, ++j;
      else if (j >= m || (i < n && common[i + 1][j] >= common[i][j + 1]))
        out.push_back("-" + a[i++]);
      else
        out.push_back("+" + b[j++]);
    }
  }
  if (out.size() > most) {
    const std::size_t left = out.size() - most;
    out.resize(most);
    out.push_back("… and " + std::to_string(left) + " more lines");
  }
  for (std::string& line : out) line = printable_line(line);
  return out;
}

std::vector<Deployed> plan(const std::vector<SiteCell>& cells, const std::string& file,
                           const std::string& text, double timeout_s) {
  std::vector<Deployed> out(cells.size());
  each_at_once(cells.size(), [&](std::size_t i) {
    out[i].cell = cells[i].name;
    guarded(out[i], [&] {
      CellClient client(cells[i], timeout_s);
      plan_one(client, file, text, out[i]);
    });
  });
  return out;
}

void write(const std::vector<SiteCell>& cells, std::vector<Deployed>& planned, const std::string& file,
           const std::string& text, bool faulty_too, double timeout_s) {
  each_at_once(cells.size(), [&](std::size_t i) {
    Deployed& out = planned[i];
    if (out.state != Deployed::State::ready && !(faulty_too && out.state == Deployed::State::faulty)) return;
    guarded(out, [&] {
      CellClient client(cells[i], timeout_s);
      client.ask({{"request", "session.hello"}, {"name", "fleet deploy"}});
      const Json taken = client.ask({{"request", "session.take"}});
      if (!taken.is_object() || !taken.contains("you_hold") || taken["you_hold"] != true)
        throw Error("no-control", "another client has control");
      client.ask({{"request", "files.write"}, {"name", file}, {"text", text}, {"base", out.base}});
      out.state = Deployed::State::written;
      try {
        client.ask({{"request", "session.release"}});
      } catch (const Error&) {  // it is written all the same, and the end of the connection gives up control
      }
      client.close();
    });
  });
}

}  // namespace polyarm::fleet
