#pragma once
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace pal_statistics {

using IdType = unsigned int;
class StatisticsRegistry;

/// A registered variable; its end removes it from the registry.
class Registration {
 public:
  Registration(std::string name, IdType id, std::weak_ptr<StatisticsRegistry> owner)
      : name_(std::move(name)), id_(id), owner_(std::move(owner)) {}
  inline ~Registration();
  Registration(Registration&& other) noexcept
      : name_(std::move(other.name_)), id_(other.id_), owner_(std::move(other.owner_)) {
    other.owner_.reset();
  }
  Registration(const Registration&) = delete;
  Registration& operator=(const Registration&) = delete;

  std::string name_;
  IdType id_;
  std::weak_ptr<StatisticsRegistry> owner_;
};

/// Registrations that end together.
class RegistrationsRAII {
 public:
  RegistrationsRAII() = default;
  RegistrationsRAII(const RegistrationsRAII&) = delete;
  RegistrationsRAII& operator=(const RegistrationsRAII&) = delete;
  void add(Registration&& each) { all_.push_back(std::make_unique<Registration>(std::move(each))); }
  void removeAll() { all_.clear(); }
  inline bool remove(const std::string& name) {
    return remove_if([&](const Registration& r) { return r.name_ == name; });
  }
  inline bool remove(IdType id) {
    return remove_if([&](const Registration& r) { return r.id_ == id; });
  }
  bool enableAll() { return set_all(true); }
  bool disableAll() { return set_all(false); }

 private:
  template <typename Test>
  bool remove_if(Test test) {
    const std::size_t before = all_.size();
    for (auto at = all_.begin(); at != all_.end();) at = test(**at) ? all_.erase(at) : at + 1;
    return all_.size() != before;
  }
  inline bool set_all(bool enabled);
  std::vector<std::unique_ptr<Registration>> all_;
};

}  // namespace pal_statistics
