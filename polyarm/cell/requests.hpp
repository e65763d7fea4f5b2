#pragma once
/// What a running cell can be asked and told: one table, whoever asks. Doors (a socket, later a web server or
/// ROS) carry its requests as text and own nothing.
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace polyarm::cell {

class Cell;

/// A row of the table, for help and the reference page.
struct RequestInfo {
  const char* name;       ///< "control.switch"
  const char* arguments;  ///< "activate: [NAME], deactivate: [NAME], strictness, dry"
  const char* text;       ///< one sentence
  bool moves;             ///< it may make something move, or stop
};
const std::vector<RequestInfo>& request_table();

/// Takes an answer, one JSON object without line ends; false when nobody listens any more.
using Answer = std::function<bool(const std::string& line)>;

/// Cell thread. A request is `{"request": NAME, …arguments, "id": anything}`; its answer `{"id": …, "ok":
/// true, "result": …}` or `{"id": …, "ok": false, "error": {code, what, advice, where}}`. What takes a few
/// cycles is answered when it is done; what goes on (`watch`, goals) is answered again and again, with
/// `"more": true`.
class Requests {
 public:
  explicit Requests(Cell& cell);
  ~Requests();
  void handle(const std::string& line, Answer answer);
  /// Once each tick: goes on with what takes time.
  void tick();

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::cell
