/// What a command may be told on the command line, declared without the parser's header.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/files.h"

namespace CLI {
class App;
}

namespace partscribe::cli {

/// An option ("--units") or operand ("scan") as it was declared: what help, manual page and completions say of it.
struct Declared {
  enum class Takes { nothing, word, list, number, count, file, folder };  // list: words between commas
  std::string name, value_name, help;
  Takes takes = Takes::word;
  std::vector<std::string> words = {};  ///< that it may be given; empty: any
  bool repeated = false;                ///< an operand of which there may be several
  double low = 0, high = 0;             ///< of numbers and counts
  std::string letter = {};              ///< "-o", which means the same; empty: none
  bool other_words = false;             ///< it takes others than `words` as well
  bool is_option() const { return name.starts_with('-'); }
  bool takes_words() const { return takes != Takes::nothing && takes != Takes::file && takes != Takes::folder; }
};

/// Options and operands of one command; each declaration binds a variable that must outlive the parsing. Numbers are
/// read by parse_number and must lie in the stated range.
class Arguments {
 public:
  explicit Arguments(CLI::App& app) : app_(app) {}

  /// "--quiet": true when given.
  void flag(bool& target, const std::string& name, const std::string& help);
  void text(std::string& target, const std::string& name, const std::string& value_name, const std::string& help);
  /// One of a few words.
  void choice(std::string& target, const std::string& name, const std::vector<std::string>& words,
              const std::string& help);
  /// What an option takes besides its words.
  struct Others {
    std::string what;  ///< "a direction X,Y,Z"; empty: nothing
    std::function<bool(const std::string&)> known;
  };
  /// One of many words, or one of the others.
  void choice(std::string& target, const std::string& name, const std::string& value_name,
              const std::vector<std::string>& words, const Others& others, const std::string& help);
  void number(std::optional<double>& target, const std::string& name, const std::string& value_name, double low,
              double high, const std::string& help);
  void number(double& target, const std::string& name, const std::string& value_name, double low, double high,
              const std::string& help);
  void count(int& target, const std::string& name, const std::string& value_name, int low, int high,
             const std::string& help);
  /// `letter`: a short name beside it ("-o").
  void path(Path& target, const std::string& name, const std::string& value_name, const std::string& help,
            const std::string& letter = {});
  /// Comma-separated ones of a few words.
  void list(std::vector<std::string>& target, const std::string& name, const std::string& value_name,
            const std::vector<std::string>& words, const std::string& help);
  /// Operands: required, at least one.
  void paths(std::vector<Path>& target, const std::string& name, const std::string& help);
  /// A single required operand.
  void operand(Path& target, const std::string& name, const std::string& help);

  /// All of them, in the order of their declaration.
  const std::vector<Declared>& declared() const { return declared_; }

 private:
  CLI::App& app_;
  std::vector<Declared> declared_;

  /// Keeps it; the answer is its help as the parser wants it.
  std::string noted(Declared declared);
};

}  // namespace partscribe::cli
