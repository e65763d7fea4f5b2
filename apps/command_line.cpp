#include "apps/command_line.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <deque>
#include <utility>

#include "apps/verb.hpp"

namespace polyarm::apps {

struct CommandLine::State {
  std::unique_ptr<CLI::App> own;  ///< none of a subcommand, which its parent owns
  CLI::App* app = nullptr;
  std::deque<Option> options{};
  std::vector<std::unique_ptr<CommandLine>> subcommands{};
};

namespace {

bool is_named_value(const std::string& word) {
  const auto at = word.find(":=");
  return at != std::string::npos && at > 0 &&
         std::all_of(word.begin(), word.begin() + static_cast<std::ptrdiff_t>(at),
                     [](unsigned char c) { return std::isalnum(c) || c == '_'; });
}

}  // namespace

Option* Option::required() {
  option_->required();
  return this;
}
Option* Option::expected(int count) {
  option_->expected(count);
  return this;
}
Option* Option::expected(int least, int most) {
  option_->expected(least, most);
  return this;
}
Option* Option::delimiter(char character) {
  option_->delimiter(character);
  return this;
}
Option* Option::excludes(Option* other) {
  option_->excludes(other->option_);
  return this;
}
Option* Option::needs(Option* other) {
  option_->needs(other->option_);
  return this;
}
Option* Option::capture_default_str() {
  option_->capture_default_str();
  return this;
}
Option* Option::type_name(const std::string& name) {
  option_->type_name(name);
  return this;
}
Option* Option::range(int low, int high) {
  option_->check(CLI::Range(low, high));
  return this;
}
Option* Option::range(double low, double high) {
  option_->check(CLI::Range(low, high));
  return this;
}
Option* Option::positive() {
  option_->check(CLI::PositiveNumber);
  return this;
}
Option* Option::not_negative() {
  option_->check(CLI::NonNegativeNumber);
  return this;
}
Option* Option::one_of(std::initializer_list<const char*> words) {
  option_->check(CLI::IsMember(std::vector<std::string>(words.begin(), words.end())));
  return this;
}
Option* Option::existing_file() {
  option_->check(CLI::ExistingFile);
  return this;
}
Option* Option::existing_folder() {
  option_->check(CLI::ExistingDirectory);
  return this;
}
Option* Option::existing_path() {
  option_->check(CLI::ExistingPath);
  return this;
}
Option* Option::check(std::function<std::string(const std::string&)> wrong, const std::string& name) {
  option_->check(
      CLI::Validator([wrong = std::move(wrong)](std::string& value) { return wrong(value); }, name));
  return this;
}

CommandLine::CommandLine(const std::string& description, const std::string& name)
    : state_(new State{std::make_unique<CLI::App>(description, name)}) {
  state_->app = state_->own.get();
}
CommandLine::CommandLine(std::unique_ptr<State> state) : state_(std::move(state)) {}
CommandLine::~CommandLine() = default;

Option* CommandLine::kept(CLI::Option* option) {
  return &state_->options.emplace_back(option);
}

Option* CommandLine::add_option(const std::string& names, std::string& value, const std::string& help) {
  return kept(state_->app->add_option(names, value, help));
}
Option* CommandLine::add_option(const std::string& names, double& value, const std::string& help) {
  return kept(state_->app->add_option(names, value, help));
}
Option* CommandLine::add_option(const std::string& names, int& value, const std::string& help) {
  return kept(state_->app->add_option(names, value, help));
}
Option* CommandLine::add_option(const std::string& names, unsigned& value, const std::string& help) {
  return kept(state_->app->add_option(names, value, help));
}
Option* CommandLine::add_option(const std::string& names, std::size_t& value, const std::string& help) {
  return kept(state_->app->add_option(names, value, help));
}
Option* CommandLine::add_option(const std::string& names, std::filesystem::path& value,
                                const std::string& help) {
  return kept(state_->app->add_option(names, value, help));
}
Option* CommandLine::add_option(const std::string& names, std::vector<std::string>& value,
                                const std::string& help) {
  return kept(state_->app->add_option(names, value, help));
}
Option* CommandLine::add_option(const std::string& names, std::vector<double>& value,
                                const std::string& help) {
  return kept(state_->app->add_option(names, value, help));
}
Option* CommandLine::add_option_function(const std::string& names,
                                         const std::function<void(const std::string&)>& take,
                                         const std::string& help) {
  return kept(state_->app->add_option_function<std::string>(names, take, help));
}
Option* CommandLine::add_option_function(const std::string& names, const std::function<void(double)>& take,
                                         const std::string& help) {
  return kept(state_->app->add_option_function<double>(
      names, [take](const double& value) { take(value); }, help));
}
Option* CommandLine::add_flag(const std::string& names, bool& value, const std::string& help) {
  return kept(state_->app->add_flag(names, value, help));
}
Option* CommandLine::add_flag_callback(const std::string& names, const std::function<void()>& act,
                                       const std::string& help) {
  return kept(state_->app->add_flag_callback(names, act, help));
}

CommandLine* CommandLine::add_subcommand(const std::string& name, const std::string& help) {
  std::unique_ptr<State> state(new State{nullptr, state_->app->add_subcommand(name, help)});
  state_->subcommands.emplace_back(new CommandLine(std::move(state)));
  return state_->subcommands.back().get();
}
void CommandLine::require_subcommand() {
  state_->app->require_subcommand(1);
}
void CommandLine::footer(const std::string& text) {
  state_->app->footer(text);
}

std::optional<int> CommandLine::parse(int argc, char** argv) {
  try {
    std::vector<std::string> words(argv + 1, argv + argc);
    // An option that takes many values would take what stands behind them, too.
    if (std::find(words.begin(), words.end(), "--") == words.end()) {
      const auto named = std::stable_partition(words.begin(), words.end(),
                                               [](const std::string& word) { return !is_named_value(word); });
      if (named != words.end()) words.insert(named, "--");
    }
    std::reverse(words.begin(), words.end());
    state_->app->parse(std::move(words));
    return std::nullopt;
  } catch (const CLI::ParseError& e) {
    const int code = state_->app->exit(e);
    return code == 0 ? kOk : kUsage;
  }
}

std::string CommandLine::subcommand() const {
  return state_->app->get_subcommands().front()->get_name();
}
bool CommandLine::parsed() const {
  return state_->app->parsed();
}
std::size_t CommandLine::count(const std::string& option) const {
  return state_->app->count(option);
}

}  // namespace polyarm::apps
