#include "apps/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <deque>
#include <numbers>
#include <utility>

#include "apps/verb.hpp"
#include "polyarm/base/quantity.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

struct CommandLine::State {
  std::unique_ptr<CLI::App> own;  ///< null for a subcommand, which its parent owns
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

/// Runs before CLI11 converts the words to numbers, so the errors are in our words.
CLI::Option* of_numbers(CLI::Option* option, bool whole, bool natural) {
  option->check(CLI::Validator(
      [whole, natural](std::string& value) {
        const auto number = parse_number(value);
        const bool fits = number && (!whole || *number == std::floor(*number)) && (!natural || *number >= 0);
        if (fits) return std::string{};
        return "'" + value + "' was given, " +
               (natural ? "a whole number of at least 0"
                : whole ? "a whole number"
                        : "a number") +
               " was expected";
      },
      "", "type"));
  return option;
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> out;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) out.push_back("--" + name);
    for (const std::string& name : option->get_snames()) out.push_back("-" + name);
  }
  return out;
}

/// The last part of the command line that was parsed: a subcommand, or the verb.
const CLI::App& innermost(const CLI::App& app) {
  const auto inner = app.get_subcommands();
  return inner.empty() ? app : innermost(*inner.front());
}

/// The verb and its subcommands, as a person types them.
std::string full_name(const CLI::App& app) {
  std::string out = app.get_display_name();
  for (const auto* part : app.get_subcommands()) out += " " + full_name(*part);
  return out;
}

/// The words that an argument takes, from one_of(): "{a,b}" within the name of its type.
std::string choices(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const auto begin = type.find('{'), end = type.find('}');
  if (begin == std::string::npos || end == std::string::npos) return {};
  return " (" + join(split_words(type.substr(begin + 1, end - begin - 1), ","), ", ") + ")";
}

std::string shown_name(const CLI::Option& option) {
  return option.get_positional() ? option.get_name(true) : option.get_name();
}

/// What a command line lacks: arguments, options or a subcommand, each with the words that fit there.
std::string missing(const CLI::App& app) {
  const CLI::App& at = innermost(app);
  std::string out;
  for (const CLI::Option* option : at.get_options())
    if (option->get_required() && option->count() == 0)
      out += shown_name(*option) + " is missing" +
             (option->get_description().empty() ? "" : ": " + option->get_description()) + choices(*option) +
             "\n";
  if (!out.empty() || at.get_require_subcommand_min() == 0) return out;
  std::vector<std::string> parts;
  for (const CLI::App* part : at.get_subcommands([](const CLI::App*) { return true; }))
    parts.push_back(part->get_name());
  return "'" + full_name(app) + "' needs one of these words: " + join(parts, ", ") + "\n";
}

std::string values(int count) {
  return std::to_string(count) + (count == 1 ? " value" : " values");
}

/// An option or argument with too few or too many values; `what`: CLI11's "NAME: … [received N]".
std::string wrong_count(const CLI::App& app, const std::string& what) {
  const std::string name = what.substr(0, what.find(':'));
  const auto number = what.rfind("received ");
  const double given = number == std::string::npos ? 0 : parse_number(what.substr(number + 9)).value_or(0);
  for (const CLI::Option* option : innermost(app).get_options()) {
    if (shown_name(*option) != name) continue;
    const int least = option->get_items_expected_min(), most = option->get_items_expected_max();
    const std::string takes = least == most                                   ? values(least)
                              : most >= CLI::detail::expected_max_vector_size ? "at least " + values(least)
                              : least == 0                                    ? "at most " + values(most)
                                           : std::to_string(least) + " to " + values(most);
    return name + " takes " + takes + ", " + (given == 0 ? "none" : format_number(given)) +
           (given <= 1 ? " was given\n" : " were given\n");
  }
  return {};
}

/// Words that belong to no option or argument, each with the nearest known one.
std::string not_understood(const CLI::App& app) {
  const std::vector<std::string> rest = app.remaining(true);
  const CLI::App& at = innermost(app);
  std::vector<std::string> parts;
  for (const CLI::App* part : at.get_subcommands([](const CLI::App*) { return true; }))
    parts.push_back(part->get_name());
  // Before the options: those that follow belong to the word that is wrong.
  if (!parts.empty() && !rest.empty() && !rest.front().starts_with('-'))
    return "there is no '" + at.get_name() + " " + rest.front() + "'" + did_you_mean(rest.front(), parts) +
           " (" + join(parts, ", ") + ")\n";
  std::string out;
  for (const std::string& word : rest) {
    if (word.size() < 2 || word.front() != '-') continue;
    const std::string name = word.substr(0, word.find('='));
    out += "there is no option '" + name + "'" + did_you_mean(name, option_names(at)) + "\n";
  }
  if (!out.empty() || rest.empty()) return out;
  return "'" + join(rest, "' '") + "': nothing takes " + (rest.size() == 1 ? "this word" : "these words") +
         ", or it is given twice\n";
}

/// What is wrong, in our words; CLI11's where there are no better ones.
std::string wrong_in(const CLI::App& app, const CLI::ParseError& error) {
  std::string out = not_understood(app);
  if (out.empty() && dynamic_cast<const CLI::RequiredError*>(&error)) out = missing(app);
  if (out.empty() && dynamic_cast<const CLI::ArgumentMismatch*>(&error)) out = wrong_count(app, error.what());
  return out.empty() ? error.what() + std::string("\n") : out;
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
  return range(static_cast<double>(low), static_cast<double>(high));
}
Option* Option::range(double low, double high) {
  return bounded([=](double n) { return n >= low && n <= high; },
                 "from " + format_number(low) + " to " + format_number(high));
}
Option* Option::positive() {
  return bounded([](double n) { return n > 0; }, "above 0");
}
Option* Option::not_negative() {
  return bounded([](double n) { return n >= 0; }, "of at least 0");
}
Option* Option::angle() {
  option_->transform(CLI::Validator(
      [](std::string& value) -> std::string {
        constexpr double kTurn = 2 * std::numbers::pi + 1e-3;  // also a turn that is rounded
        if (const auto bare = parse_number(value))
          return std::abs(*bare) <= kTurn ? std::string{}
                                          : "'" + value + "' radians are more than a turn; write " + value +
                                                "deg or " + value + "rad";
        if (const auto radians = parse_quantity(value, Dimension::angle))
          value = fmt::format("{:.17g}", *radians);
        return {};
      },
      "", "angle"));
  return this;
}
/// Only numbers get here; the option's type refuses other values first.
Option* Option::bounded(const std::function<bool(double)>& fits, const std::string& which) {
  option_->check(CLI::Validator(
      [=](std::string& value) {
        const auto number = parse_number(value);
        return number && fits(*number) ? std::string{}
                                       : "'" + value + "' was given, a number " + which + " was expected";
      },
      "", "bounds"));
  return this;
}
Option* Option::one_of(std::initializer_list<const char*> words) {
  const std::vector<std::string> all(words.begin(), words.end());
  option_->check(CLI::Validator(
      [all](std::string& value) {
        if (std::find(all.begin(), all.end(), value) != all.end()) return std::string{};
        return "there is no '" + value + "'" + did_you_mean(value, all) + " (" + join(all, ", ") + ")";
      },
      "{" + join(all, ",") + "}"));
  return this;
}
Option* Option::existing_file() {
  return check(
      [](const std::string& path) -> std::string {
        std::error_code error;
        if (std::filesystem::is_directory(path, error))
          return "'" + path + "' is a folder, a file was expected";
        return std::filesystem::exists(path, error) ? "" : "there is no file '" + path + "'";
      },
      "FILE");
}
Option* Option::existing_folder() {
  return check(
      [](const std::string& path) -> std::string {
        std::error_code error;
        if (std::filesystem::is_directory(path, error)) return "";
        return std::filesystem::exists(path, error) ? "'" + path + "' is a file, a folder was expected"
                                                    : "there is no folder '" + path + "'";
      },
      "DIR");
}
Option* Option::existing_path() {
  return check(
      [](const std::string& path) -> std::string {
        std::error_code error;
        return std::filesystem::exists(path, error) ? "" : "there is no file or folder '" + path + "'";
      },
      "PATH(existing)");
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
  return kept(of_numbers(state_->app->add_option(names, value, help), false, false));
}
Option* CommandLine::add_option(const std::string& names, int& value, const std::string& help) {
  return kept(of_numbers(state_->app->add_option(names, value, help), true, false));
}
Option* CommandLine::add_option(const std::string& names, unsigned& value, const std::string& help) {
  return kept(of_numbers(state_->app->add_option(names, value, help), true, true));
}
Option* CommandLine::add_option(const std::string& names, std::size_t& value, const std::string& help) {
  return kept(of_numbers(state_->app->add_option(names, value, help), true, true));
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
  return kept(of_numbers(state_->app->add_option(names, value, help), false, false));
}
Option* CommandLine::add_option_function(const std::string& names,
                                         const std::function<void(const std::string&)>& take,
                                         const std::string& help) {
  return kept(state_->app->add_option_function<std::string>(names, take, help));
}
Option* CommandLine::add_option_function(const std::string& names, const std::function<void(double)>& take,
                                         const std::string& help) {
  return kept(of_numbers(state_->app->add_option_function<double>(
                             names, [take](const double& value) { take(value); }, help),
                         false, false));
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
    // An option with many values would also take the words after it.
    if (std::find(words.begin(), words.end(), "--") == words.end()) {
      const auto named = std::stable_partition(words.begin(), words.end(),
                                               [](const std::string& word) { return !is_named_value(word); });
      if (named != words.end()) words.insert(named, "--");
    }
    std::reverse(words.begin(), words.end());
    state_->app->parse(std::move(words));
    return std::nullopt;
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) {  // --help
      state_->app->exit(e);
      return kOk;
    }
    fmt::print(stderr, "{}{} --help lists what is possible.\n", wrong_in(*state_->app, e),
               full_name(*state_->app));
    return kUsage;
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
