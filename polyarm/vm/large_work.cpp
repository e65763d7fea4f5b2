#include "polyarm/vm/large_work.hpp"

#include <algorithm>

#include "polyarm/language/operators.hpp"

namespace polyarm::program {

namespace {
// In plain steps. A separately stored part costs extra here, for its later release.
constexpr int kPlain = 2, kPart = data::Remains::kShared, kMade = 28;
constexpr std::size_t kBytesOfAStep = 64, kLettersOfAStep = 2;

int cost_of_copy(const Value& value) {
  return value.is_shared() ? kPart : kPlain;
}
}  // namespace

int Work::go_on() {
  int left = kPiece;
  if (!done_) done_ = go_on(left);
  return kPiece - left;
}

// Copying.

Copying::Copying(Value first, Value second, std::size_t room)
    : first_{std::move(first)}, second_{std::move(second)} {
  made_.reserve(std::max(room, first_.as_list()->size() + second_.as_list()->size()));
}

bool Copying::go_on(int& left) {
  const data::List &first = *first_.as_list(), &second = *second_.as_list();
  while (left > 0 && made_.size() < first.size() + second.size()) {
    const std::size_t at = made_.size();
    const Value& part = at < first.size() ? first[at] : second[at - first.size()];
    left -= cost_of_copy(part);
    made_.push_back(part);
  }
  return made_.size() == first.size() + second.size();
}

Value Copying::take() {
  const Value::Extent a = first_.extent(), b = second_.extent();
  return {std::move(made_), {a.values + b.values - 1, std::max(a.depth, b.depth)}};
}

// Comparing.

Comparing::Comparing(Value a, Value b) : a_{std::move(a)}, b_{std::move(b)} {}

bool Comparing::open(const Value& a, const Value& b) {
  const data::Record *x = a.as_record(), *y = b.as_record();
  const std::size_t size = x ? x->values.size() : a.as_list()->size();
  if (size != (y ? y->values.size() : b.as_list()->size())) return false;
  open_.push_back({&a, &b, 0});
  return true;
}

bool Comparing::look(const Value& a, const Value& b, int& left) {
  left -= a.is_shared() ? kPart : kPlain;
  if (a.kind() != b.kind()) return false;
  if (a.is_same(b)) return true;
  if (a.as_list() || a.as_record()) return open(a, b);
  if (a.as_text()) left -= static_cast<int>(a.as_text()->size() / kBytesOfAStep);
  return equal_values(a, b);
}

bool Comparing::go_on(int& left) {
  if (!std::exchange(begun_, true)) equal_ = look(a_, b_, left);
  while (equal_ && !open_.empty() && left > 0) {
    Level& level = open_.back();
    const data::Record *x = level.a->as_record(), *y = level.b->as_record();
    const data::List& parts = x ? x->values : *level.a->as_list();
    if (level.next == parts.size()) {
      open_.pop_back();
      continue;
    }
    const std::size_t at = level.next++;
    const Value* other = !x                             ? &(*level.b->as_list())[at]
                         : y->names[at] == x->names[at] ? &y->values[at]
                                                        : y->find(x->names[at]);
    equal_ = other && look(parts[at], *other, left);
  }
  return !equal_ || open_.empty();
}

// Writing.

bool Writing::go_on(int& left) {
  while (left > 0 && next_ < parts_.size() && text_.size() <= kLongestText) {
    if (telling_.empty()) {
      if (next_ > 0) text_ += between_;
      telling_.emplace_back(parts_[next_], data::kShownDigits);
    }
    const std::size_t before = text_.size();
    const bool told = telling_.back().go_on(text_, static_cast<std::size_t>(left) / kLettersOfAStep + 1);
    const std::size_t letters = text_.size() - before;
    const bool as_it_is = parts_[next_].as_text() != nullptr;
    left -= static_cast<int>(as_it_is ? letters / kBytesOfAStep : letters * kLettersOfAStep) + 1;
    if (!told) continue;
    telling_.clear();
    ++next_;
  }
  return next_ == parts_.size() || text_.size() > kLongestText;
}

// Making.

bool Making::go_on(int& left) {
  made_.reserve(series_.count);
  for (; left > 0 && made_.size() < series_.count; left -= kMade) {
    made_.push_back(series_.at(made_.size()));
    const Value::Extent each = made_.back().extent();
    extent_ = {extent_.values + each.values, std::max(extent_.depth, each.depth + 1)};
  }
  return made_.size() == series_.count;
}

Value Making::take() {
  require_fits(extent_);
  return {std::move(made_), extent_};
}

}  // namespace polyarm::program
