#pragma once
#include <stdexcept>
#include <string>

#include "polyarm_ros/standard.hpp"

namespace tf2 {
class TransformException : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
class LookupException : public TransformException {
 public:
  using TransformException::TransformException;
};
class ConnectivityException : public TransformException {
 public:
  using TransformException::TransformException;
};
class ExtrapolationException : public TransformException {
 public:
  using TransformException::TransformException;
};
class InvalidArgumentException : public TransformException {
 public:
  using TransformException::TransformException;
};
class TimeoutException : public TransformException {
 public:
  using TransformException::TransformException;
};
}  // namespace tf2
