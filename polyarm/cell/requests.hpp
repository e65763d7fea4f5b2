#pragma once
/// What a running cell can be asked and told: one table, whoever asks. Doors (a socket, later a web server or
/// ROS) carry its requests as text and own nothing.
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace polyarm::cell {

class Cell;

/// What an argument of a request may be: a text, a number, true or false, names (one text or a list of
/// them), a map, a message (a map, or a text in YAML or JSON), or any JSON value.
enum class ArgumentType { text, number, flag, names, map, message, any };
const char* name(ArgumentType type);

struct RequestArgument {
  const char* name;
  ArgumentType type;
  bool needed = false;
};

/// A row of the table, for help and the reference page.
struct RequestInfo {
  const char* name;  ///< "control.switch"
  std::vector<RequestArgument> arguments;
  const char* result;  ///< keys of the answer's `result`
  const char* text;    ///< one sentence
  bool moves;          ///< it may make something move, or stop
};
const std::vector<RequestInfo>& request_table();
/// The table as Markdown, as docs/control.md has it.
std::string request_reference();

/// Brackets outside texts nested deeper (64) than any request has: copying and printing JSON recurses.
bool nested_too_deep(const std::string& line);

/// Is there one of that name?
bool knows_request(const std::string& name);
/// The `id` of a request; null: none. Throws Error("bad-request") for what is too long to be kept.
nlohmann::json request_id(const nlohmann::json& request);

/// Takes an answer, one JSON object without line ends; false when nobody listens any more.
using Answer = std::function<bool(const std::string& line)>;
/// The same for an asker in this process: the answer is neither printed nor parsed.
using JsonAnswer = std::function<bool(nlohmann::json answer)>;

/// Cell thread. A request is `{"request": NAME, …arguments, "id": anything}`; its answer `{"id": …, "ok":
/// true, "result": …}` or `{"id": …, "ok": false, "error": {code, what, advice, where}}`. What takes a few
/// cycles is answered when it is done; what goes on (`watch`, goals) is answered again and again, with
/// `"more": true`. Requests of one asker are begun one after the other, each when the one before it has been
/// answered (a `watch` or goal: when it has been answered first); only control.hold and control.stop pass.
class Requests {
 public:
  explicit Requests(Cell& cell);
  ~Requests();
  /// `from` tells askers apart (an address that is unique while the asker is there); null: nobody waits.
  void handle(const std::string& line, Answer answer, const void* from = nullptr);
  /// The same of one that was read from so many bytes already.
  void handle(nlohmann::json request, std::size_t bytes, Answer answer, const void* from = nullptr);
  void ask(nlohmann::json request, std::size_t bytes, JsonAnswer answer, const void* from = nullptr);
  /// What this asker has open under this id (not null) ends without a further answer.
  void end(const void* from, const nlohmann::json& id);
  /// Once each tick: goes on with what takes time.
  void tick();
  std::size_t open() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::cell
