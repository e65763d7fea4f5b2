#pragma once
/// The requests to a running cell, whoever makes them: in-process callers hand over structs and get structs, doors
/// hand over lines of text. Doors (a socket, the pendant's port, ROS 2) own nothing.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/protocol/request.hpp"

namespace polyarm::cell {

struct CellInside;
struct Handler;

/// Cell thread. What takes a few cycles is answered when it is done; what goes on (`watch`, goals) is answered again
/// and again, with `more`. Requests of one asker begin one after the other, each when the one before it has been
/// answered (a `watch` or goal: when it has been answered first); only urgent ones, which stop, overtake.
class Requests {
 public:
  /// Takes a reply; false when nobody listens any more.
  using OnReply = std::function<bool(const protocol::Reply& reply)>;
  /// Takes a reply as one line of JSON without its end; false when nobody listens any more.
  using OnLine = std::function<bool(const std::string& line)>;

  /// `handlers`: every request that it answers.
  Requests(CellInside& cell, const std::vector<Handler>& handlers);
  ~Requests();
  /// `from` tells askers apart (an address that is unique while the asker is there); null: nobody waits.
  /// `bytes`: about the memory of a request that may be large; counts towards bounds::kOpenRequestBytes.
  void ask(protocol::Request request, OnReply on_reply, const void* from = nullptr, std::size_t bytes = 0);
  /// From a socket: `{"request": NAME, …arguments, "id": anything}`.
  void handle(const std::string& line, OnLine on_line, const void* from = nullptr);
  /// The same, parsed already from that many bytes.
  void handle(const protocol::Any& fields, std::size_t bytes, OnLine on_line, const void* from = nullptr);
  /// What this asker has open under this id (not null) ends without a further reply.
  void end(const void* from, const protocol::Any& id);
  /// What this asker has open ends: what was not answered yet is refused for this reason.
  void refuse(const void* from, const Error& why);
  /// Once each tick: goes on with what takes time.
  void tick();
  std::size_t open() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::cell
