#pragma once
/// A link as a cell has it: values by name.
#include <map>
#include <string>
#include <vector>

#include "polyarm/signals/links_file.hpp"
#include "polyarm/yaml/yaml.hpp"
#include "tests/links/peers.hpp"

namespace polyarm::test {

/// The one link of the text, whose `PORT` is filled in. Throws what is wrong with it.
inline signals::LinkEntry link_entry(std::string text, int port) {
  if (const auto at = text.find("PORT"); at != std::string::npos) text.replace(at, 4, std::to_string(port));
  Problems problems;
  auto links = signals::read_links(Yaml::parse(text, "links.yaml"), ".", problems);
  problems.throw_if_errors();
  return links.at(0);
}

class RunningLink {
 public:
  RunningLink(signals::LinkEntry entry, std::unique_ptr<signals::LinkPort> port)
      : entry_(entry), link_(std::move(entry), std::move(port), {true, 20'000'000, 100'000'000}) {}

  void post(const std::string& name, const data::Value& value) { link_.post(index(name), value); }
  void look() {
    for (signals::LinkEvent& event : link_.take_events()) {
      if (event.kind == signals::LinkEvent::Kind::value) values[entry_.tags[event.tag].name] = event.value;
      if (event.kind == signals::LinkEvent::Kind::refused) refusals.push_back(event.text);
      if (event.kind == signals::LinkEvent::Kind::lost) losses.push_back(event.text);
    }
  }
  bool up() {
    return eventually([&] { return look(), link_.state().up; });
  }
  bool down() {
    return eventually([&] { return look(), !link_.state().up; });
  }
  bool comes(const std::string& name, const data::Value& value) {
    return eventually([&] {
      look();
      return values.contains(name) && values.at(name) == value;
    });
  }
  bool refuses(const std::string& part) {
    return eventually([&] {
      look();
      for (const std::string& why : refusals)
        if (why.find(part) != std::string::npos) return true;
      return false;
    });
  }
  bool given() {
    return eventually([&] { return look(), link_.idle(); });
  }
  signals::Link& link() { return link_; }

  std::map<std::string, data::Value> values;
  std::vector<std::string> refusals, losses;

 private:
  std::size_t index(const std::string& name) const {
    for (std::size_t i = 0; i < entry_.tags.size(); ++i)
      if (entry_.tags[i].name == name) return i;
    throw std::runtime_error("no tag " + name);
  }
  signals::LinkEntry entry_;
  signals::Link link_;
};

}  // namespace polyarm::test
