#pragma once
/// The menu of interactive markers: entries below entries, with check marks.
#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "interactive_markers/interactive_marker_server.hpp"
#include "visualization_msgs/msg/menu_entry.hpp"

namespace interactive_markers {

class MenuHandler {
  using MenuEntry = visualization_msgs::msg::MenuEntry;

 public:
  using EntryHandle = std::uint32_t;
  enum CheckState { NO_CHECKBOX, CHECKED, UNCHECKED };
  using FeedbackConstPtr = InteractiveMarkerServer::FeedbackConstPtr;
  using FeedbackCallback = InteractiveMarkerServer::FeedbackCallback;

  EntryHandle insert(const std::string& title, const FeedbackCallback& call) {
    return add(0, title, MenuEntry::FEEDBACK, "", call);
  }
  EntryHandle insert(const std::string& title, std::uint8_t type = MenuEntry::FEEDBACK,
                     const std::string& command = "") {
    return add(0, title, type, command, nullptr);
  }
  EntryHandle insert(EntryHandle parent, const std::string& title, const FeedbackCallback& call) {
    return add(parent, title, MenuEntry::FEEDBACK, "", call);
  }
  EntryHandle insert(EntryHandle parent, const std::string& title, std::uint8_t type = MenuEntry::FEEDBACK,
                     const std::string& command = "") {
    return add(parent, title, type, command, nullptr);
  }
  bool setVisible(EntryHandle handle, bool visible) {
    return change(handle, [&](Entry& e) { e.visible = visible; });
  }
  bool setCheckState(EntryHandle handle, CheckState state) {
    return change(handle, [&](Entry& e) { e.state = state; });
  }
  bool getCheckState(EntryHandle handle, CheckState& out) const {
    const auto found = all_.find(handle);
    return found != all_.end() && (out = found->second.state, true);
  }
  bool getTitle(EntryHandle handle, std::string& out) const {
    const auto found = all_.find(handle);
    return found != all_.end() && (out = found->second.title, true);
  }
  bool apply(InteractiveMarkerServer& server, const std::string& name) {
    visualization_msgs::msg::InteractiveMarker marker;
    if (!server.get(name, marker)) {
      markers_.erase(name);
      return false;
    }
    marker.menu_entries.clear();
    for (const auto& [handle, entry] : all_) {
      if (!shown(handle)) continue;
      MenuEntry made;
      made.id = handle;
      made.parent_id = entry.parent;
      made.title =
          entry.state == NO_CHECKBOX ? entry.title : (entry.state == CHECKED ? "[x] " : "[ ] ") + entry.title;
      made.command = entry.command;
      made.command_type = entry.type;
      marker.menu_entries.push_back(std::move(made));
    }
    server.insert(
        marker, [this](const FeedbackConstPtr& f) { take(f); },
        visualization_msgs::msg::InteractiveMarkerFeedback::MENU_SELECT);
    markers_.insert(name);
    return true;
  }
  bool reApply(InteractiveMarkerServer& server) {
    bool all = true;
    for (const std::string& name : std::set<std::string>(markers_)) all = apply(server, name) && all;
    return all;
  }

 private:
  struct Entry {
    EntryHandle parent;
    std::string title, command;
    std::uint8_t type;
    FeedbackCallback call;
    bool visible = true;
    CheckState state = NO_CHECKBOX;
  };
  EntryHandle add(EntryHandle parent, const std::string& title, std::uint8_t type, const std::string& command,
                  const FeedbackCallback& call) {
    all_.emplace(++last_, Entry{parent, title, command, type, call});
    return last_;
  }
  template <typename Change>
  bool change(EntryHandle handle, Change apply_to) {
    const auto found = all_.find(handle);
    return found != all_.end() && (apply_to(found->second), true);
  }
  bool shown(EntryHandle handle) const {
    for (; handle != 0; handle = all_.at(handle).parent)
      if (!all_.count(handle) || !all_.at(handle).visible) return false;
    return true;
  }
  void take(const FeedbackConstPtr& message) {
    const auto found = all_.find(message->menu_entry_id);
    if (found != all_.end() && found->second.call) found->second.call(message);
  }
  std::map<EntryHandle, Entry> all_;
  std::set<std::string> markers_;
  EntryHandle last_ = 0;
};

}  // namespace interactive_markers
