#pragma once
/// Who of those that are connected may move the cell: one at a time, who is asked before another takes over.
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace polyarm::server {

/// What is to be told to one of them.
struct ControlNews {
  enum class What { asked, given, refused, taken, lost, free };
  std::uint64_t to = 0;  ///< client; 0: all
  What what = What::asked;
  std::uint64_t other = 0;  ///< who asks, or has it now
};

/// Pure: time comes from outside, s. Clients are numbers from 1.
class Control {
 public:
  /// Who is asked and does not answer for so long has lost it.
  static constexpr double kPatience = 10;

  std::uint64_t holder() const { return holder_; }
  /// Who waits for the holder's answer; 0: nobody.
  std::uint64_t asker() const { return asker_; }
  bool holds(std::uint64_t client) const { return client != 0 && client == holder_; }
  /// s until the holder has lost it.
  double left(double now) const;

  enum class Taken { yes, asked, others };  ///< others: somebody else asks already
  /// `at_once`: the holder is told and not asked.
  Taken take(std::uint64_t client, bool at_once, double now);
  bool release(std::uint64_t client);
  /// The holder's answer to who asks; false: it is not asked.
  bool answer(std::uint64_t client, bool give);
  /// It is not connected any more.
  void gone(std::uint64_t client);
  void tick(double now);
  std::vector<ControlNews> take_news() { return std::exchange(news_, {}); }

 private:
  void hand_to_asker(ControlNews::What to_old);

  std::uint64_t holder_ = 0, asker_ = 0;
  double until_ = 0;
  std::vector<ControlNews> news_;
};

}  // namespace polyarm::server
