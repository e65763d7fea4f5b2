#pragma once
/// Requests and answers as values. Their creators use typed structs; code that forwards them uses one common
/// type. Text exists at sockets only (wire.hpp).
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/protocol/facts.hpp"
#include "polyarm/protocol/type.hpp"

namespace polyarm::protocol {

/// The type of a request in the protocol's list. Immutable; any thread.
struct RequestType {
  const Facts* facts = nullptr;
  std::string struct_name;  ///< "ControlSwitch"
  const Type* arguments = nullptr;
  const Type* answer = nullptr;
  std::shared_ptr<void> (*make)() = nullptr;  ///< makes a request with default arguments
};

/// R: the struct of a request.
template <class R>
const RequestType& request_type();

/// All requests in the order of the reference: first those of a cell, then those that the pendant's port
/// answers.
const std::vector<const RequestType*>& request_types();
/// Null if the name is unknown.
const RequestType* find_request(const std::string& name);

/// A request of any type. Copies share its arguments.
class Request {
 public:
  template <class R>
  Request(R request) : type_(&request_type<R>()), value_(std::make_shared<R>(std::move(request))) {}
  Request(const RequestType& type, std::shared_ptr<const void> value)
      : type_(&type), value_(std::move(value)) {}
  const RequestType& type() const { return *type_; }
  const Facts& facts() const { return *type_->facts; }
  /// The arguments as a JSON object.
  Any arguments() const;
  /// R must be the struct of this request.
  template <class R>
  const R& as() const {
    return *static_cast<const R*>(value_.get());
  }

 private:
  const RequestType* type_;
  std::shared_ptr<const void> value_;
};

/// An answer of any type.
class Answer {
 public:
  template <class R>
  static Answer of(typename R::Answer answer) {
    return {request_type<R>(), std::make_shared<const typename R::Answer>(std::move(answer))};
  }
  /// R must be the struct of the request that was answered.
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

/// An answer (with `more`, others will follow), or the reason for a refusal.
struct Reply {
  std::optional<Answer> answer;
  std::optional<Error> refusal;
  bool more = false;
};

/// The role that a request with these arguments (a JSON object) needs.
Role role_needed(const RequestType& type, const Any& arguments);
Role role_needed(const Request& request);

}  // namespace polyarm::protocol
