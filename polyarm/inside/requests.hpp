#pragma once
/// Requests to a running cell, for all callers: in-process callers pass and receive structs; doors (a socket,
/// the pendant's port, ROS 2) pass and receive lines of JSON and hold no state of the cell.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/protocol/request.hpp"

namespace polyarm::cell {

struct CellInside;
struct Handler;

/// Cell thread. A request that takes a few cycles is answered when it is done. A continuing request (`watch`,
/// goals) is answered repeatedly, with `more` set. Requests of one client run in order: each begins when the
/// one before it has been answered (for a `watch` or goal: after its first answer). Only urgent requests,
/// which stop motion, overtake others.
class Requests {
 public:
  /// Receives a reply; returns false if the client no longer listens.
  using OnReply = std::function<bool(const protocol::Reply& reply)>;
  /// Receives a reply as one line of JSON without the line end; returns false if the client no longer
  /// listens.
  using OnLine = std::function<bool(const std::string& line)>;

  /// `handlers`: all requests that are answered here.
  Requests(CellInside& cell, const std::vector<Handler>& handlers);
  ~Requests();
  /// Called for each request before it is carried out, with its client (`from`). It returns a function, or an
  /// empty one, that gets the first reply; a request that ends without a reply gives Error("ended").
  using Witness =
      std::function<std::function<void(const protocol::Reply&)>(const void* from, const protocol::Request&)>;
  void set_witness(Witness witness);
  /// `from` identifies the client: an address that is unique as long as the client exists; null: requests are
  /// not ordered. `bytes` is the approximate memory of a large request; it counts towards
  /// bounds::kOpenRequestBytes.
  void ask(protocol::Request request, OnReply on_reply, const void* from = nullptr, std::size_t bytes = 0);
  /// A line from a socket: `{"request": NAME, …arguments, "id": anything}`.
  void handle(const std::string& line, OnLine on_line, const void* from = nullptr);
  /// The same, already parsed; `bytes` is the size of its text.
  void handle(const protocol::Any& fields, std::size_t bytes, OnLine on_line, const void* from = nullptr);
  /// Ends the client's open requests with this id (not null) without a further reply.
  void end(const void* from, const protocol::Any& id);
  /// Ends all open requests of the client. Those not answered yet are refused with this reason.
  void refuse(const void* from, const Error& why);
  /// Call once each tick: advances the open requests.
  void tick();
  std::size_t open() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::cell
