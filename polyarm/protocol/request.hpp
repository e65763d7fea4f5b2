#pragma once
/// Requests and answers as values: typed for who makes them, of one type for who carries them. Text exists at
/// sockets alone (wire.hpp).
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/protocol/facts.hpp"
#include "polyarm/protocol/type.hpp"

namespace polyarm::protocol {

/// A request of the protocol's list. Immutable; any thread.
struct RequestType {
  const Facts* facts = nullptr;
  std::string struct_name;  ///< "ControlSwitch"
  const Type* arguments = nullptr;
  const Type* answer = nullptr;
  std::shared_ptr<void> (*make)() = nullptr;  ///< a request with the arguments' initial values
};

/// Of a struct of the protocol's list.
template <class R>
const RequestType& request_type();

/// Every request, in the order of the reference: those of a cell first, then those of a session at the
/// pendant's port.
const std::vector<const RequestType*>& request_types();
/// Null where there is none of that name.
const RequestType* find_request(const std::string& name);

/// Any request. Copies share its arguments.
class Request {
 public:
  template <class R>
  Request(R request) : type_(&request_type<R>()), value_(std::make_shared<R>(std::move(request))) {}
  Request(const RequestType& type, std::shared_ptr<const void> value)
      : type_(&type), value_(std::move(value)) {}
  const RequestType& type() const { return *type_; }
  const Facts& facts() const { return *type_->facts; }
  /// As a JSON object.
  Any arguments() const;
  /// R is the request's own struct.
  template <class R>
  const R& as() const {
    return *static_cast<const R*>(value_.get());
  }

 private:
  const RequestType* type_;
  std::shared_ptr<const void> value_;
};

/// Any answer.
class Answer {
 public:
  template <class R>
  static Answer of(typename R::Answer answer) {
    return {request_type<R>(), std::make_shared<const typename R::Answer>(std::move(answer))};
  }
  /// R is the struct of the request that was answered.
  template <class R>
  const typename R::Answer& as() const {
    return *static_cast<const typename R::Answer*>(value_.get());
  }
  Any any() const { return written(*type_->answer, value_.get()); }

 private:
  Answer(const RequestType& type, std::shared_ptr<const void> value)
      : type_(&type), value_(std::move(value)) {}
  const RequestType* type_;
  std::shared_ptr<const void> value_;
};

/// What comes back: an answer, which may be followed by more, or why there is none.
struct Reply {
  std::optional<Answer> answer;
  std::optional<Error> refusal;
  bool more = false;
};

/// The role that a request with these arguments (a JSON object) needs.
Role role_needed(const RequestType& type, const Any& arguments);
Role role_needed(const Request& request);

}  // namespace polyarm::protocol
