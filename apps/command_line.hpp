#pragma once
/// The command line of a verb: declares options and reads them into variables. CLI11 parses it. Only
/// command_line.cpp includes CLI11, because its templates add seconds of compile time to each file.
#include <cstddef>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace polyarm::apps {

/// An option or a positional argument; valid as long as its command line. A value that fails a check is a
/// usage error.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option* required();
  /// Number of values; -1: one or more.
  Option* expected(int count);
  Option* expected(int least, int most);
  /// Separator of the values in one word.
  Option* delimiter(char character);
  Option* excludes(Option* other);
  Option* needs(Option* other);
  /// --help shows the present value as the default.
  Option* capture_default_str();
  Option* type_name(const std::string& name);

  Option* range(int low, int high);
  Option* range(double low, double high);
  Option* positive();
  Option* not_negative();
  /// Angles: radians, or with a unit such as 180deg. A bare number above 2 pi is refused.
  Option* angle();
  Option* one_of(std::initializer_list<const char*> words);
  Option* existing_file();
  Option* existing_folder();
  Option* existing_path();
  /// `wrong` returns what is wrong with a value, or an empty text. `name` is the placeholder of the value in
  /// --help.
  Option* check(std::function<std::string(const std::string&)> wrong, const std::string& name);

 private:
  Option* bounded(const std::function<bool(double)>& fits, const std::string& which);

  CLI::Option* option_;
};

/// Declares options, then parses a command line into the variables that were given with them. The variables
/// must outlive this object.
class CommandLine {
 public:
  CommandLine(const std::string& description, const std::string& name);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  Option* add_option(const std::string& names, std::string& value, const std::string& help = {});
  Option* add_option(const std::string& names, double& value, const std::string& help = {});
  Option* add_option(const std::string& names, int& value, const std::string& help = {});
  Option* add_option(const std::string& names, unsigned& value, const std::string& help = {});
  Option* add_option(const std::string& names, std::size_t& value, const std::string& help = {});
  Option* add_option(const std::string& names, std::filesystem::path& value, const std::string& help = {});
  Option* add_option(const std::string& names, std::vector<std::string>& value, const std::string& help = {});
  Option* add_option(const std::string& names, std::vector<double>& value, const std::string& help = {});
  Option* add_option_function(const std::string& names, const std::function<void(const std::string&)>& take,
                              const std::string& help);
  Option* add_option_function(const std::string& names, const std::function<void(double)>& take,
                              const std::string& help);
  Option* add_flag(const std::string& names, bool& value, const std::string& help = {});
  Option* add_flag_callback(const std::string& names, const std::function<void()>& act,
                            const std::string& help);

  CommandLine* add_subcommand(const std::string& name, const std::string& help);
  /// Makes a subcommand mandatory.
  void require_subcommand();
  /// Text below the options in --help.
  void footer(const std::string& text);

  /// Returns an exit code after --help or a usage error, which it has printed.
  std::optional<int> parse(int argc, char** argv);

  // After parse():
  /// The subcommand that was given; require_subcommand() must have been called.
  std::string subcommand() const;
  /// True if this subcommand was given.
  bool parsed() const;
  /// How often an option was given.
  std::size_t count(const std::string& option) const;

 private:
  struct State;
  explicit CommandLine(std::unique_ptr<State> state);
  Option* kept(CLI::Option* option);

  std::unique_ptr<State> state_;
};

}  // namespace polyarm::apps
