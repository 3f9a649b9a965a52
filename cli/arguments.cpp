#include "cli/arguments.h"

#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <exception>
#include <new>

#include "cli/commands.h"
#include "cli/completion.h"
#include "cli/manual.h"
#include "cli/printable.h"
#include "cli/suggest.h"
#include "core/number.h"
#include "core/process.h"
#include "verify/evaluate/run_occt.h"
#include "verify/evaluate/run_openscad.h"

namespace partscribe::cli {
namespace {

constexpr const char* program_help =
    R"(Partscribe reads 3-D scans of a part, writes the part as an editable CAD procedure and proves it by running it.

Examples
  partscribe build bracket.ply                          everything, with defaults that work
  partscribe build view*.ply --tolerance 0.1 --out cad  several views in one frame, 0.1 mm
  partscribe verify edited.scad bracket.ply             does my edited script still fit the scan?
  partscribe explain bracket-partscribe/model.json      why each dimension is what it is
  partscribe measure bracket.ply                        its faces, holes and walls, without building anything
  partscribe analyse bracket-partscribe                 its mass and inertia, and which dimensions matter
  partscribe simulate pin.stl --sigma 0.02              a scan of a shape that you know
)";

constexpr const char* program_footer =
    R"(Exit codes: 0 verified, 1 out of tolerance, 2 usage, 3 input cannot be used, 4 a needed program is missing,
5 cancelled or limit reached, 6 the scan cannot decide at this tolerance.
'partscribe help COMMAND' explains a command; 'partscribe help --man' prints all of it as a manual page,
'partscribe help --completion bash|zsh|fish' what makes a shell complete its words, 'partscribe help --markdown
COMMAND' the part of a command's page that the program writes.)";

std::string range_text(double low, double high) {
  return "a number from " + print_number(low) + " to " + print_number(high);
}

/// Lines short enough to stand in the right column of an option list.
std::string wrapped(const std::string& text) {
  constexpr std::size_t width = 84;
  std::string result;
  std::size_t column = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const auto end = std::min(text.find(' ', begin), text.size());
    const auto length = end - begin;
    if (column > 0) result += column + 1 + length > width ? '\n' : ' ';
    column = column > 0 && column + 1 + length <= width ? column + 1 + length : length;
    result += text.substr(begin, length);
    begin = end + 1;
  }
  return result;
}

/// How to write what somebody may have meant: a decimal comma, or the unit behind the number. Empty if nothing of the
/// kind is in range.
std::string written_right(const std::string& text, double low, double high) {
  std::string number = text.substr(0, text.find_last_of("0123456789") + 1);  // npos + 1 is 0
  const std::string unit = text.substr(std::min(text.find_first_not_of(' ', number.size()), text.size()));
  if (!unit.empty() && unit != "mm" && unit != "deg" && unit != "°" && unit != "s") return {};
  const auto comma = number.find(',');
  if (comma != std::string::npos) number[comma] = '.';
  const auto value = parse_number(number);
  return number != text && value && *value >= low && *value <= high ? "; write " + number : "";
}

/// Reads a number the way all files are read; the answer is CLI11's: an empty string is agreement.
std::string parse_into(double& target, const std::string& text, double low, double high) {
  const auto value = parse_number(text);
  if (!value || *value < low || *value > high)
    return "expected " + range_text(low, high) + ", found '" + text + "'" + written_right(text, low, high);
  target = *value;
  return {};
}

std::string one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  for (auto& c : text)
    if (c == '\n') c = ' ';
  return text;
}

void declare_shared(Arguments& arguments, SharedOptions& options) {
  arguments.number(options.tolerance, "--tolerance", "MM", 1e-6, 1e6,
                   "the model must lie within this of the data everywhere, in mm; smaller follows the scan more "
                   "closely and needs a better scan (default: chosen from the scan's noise, and printed)");
  arguments.choice(options.units, "--units", {"mm", "cm", "m", "inch"},
                   "unit of the numbers in the input files (default: what the file says, else mm)");
  arguments.path(options.out, "--out", "DIR", "folder for the results (default: named after the input)");
  arguments.flag(options.force, "--force", "overwrite results that exist already");
  arguments.count(options.threads, "--threads", "N", 0, 1024,
                  "processors to use; never changes a result (default 0: all)");
  arguments.flag(options.quiet, "--quiet", "print warnings and errors only");
  arguments.flag(options.json, "--json", "print the result as JSON on standard output and nothing else there");
  arguments.flag(options.progress, "--progress",
                 "say each step as a line of JSON on standard error, for programs that show it");
  arguments.path(options.log, "--log", "FILE", "append what happened, with times, to this file");
}

/// The words of the command line as the parser wants them: "help build" is "build --help", and after "--" all words are
/// files, whatever they begin with. Some commands write their JSON to a file when one is named: "--json a.json".
std::vector<std::string> words_of(int argc, const char* const* argv) {
  std::vector<std::string> words(argv + 1, argv + argc);
  if (words.front() == "help") {
    words.erase(words.begin());
    words.resize(std::min<std::size_t>(words.size(), 1));
    words.push_back("--help");
  }
  if (const auto mark = std::find(words.begin(), words.end(), "--"); mark != words.end()) {
    for (auto word = mark + 1; word != words.end(); ++word)
      if (word->starts_with('-')) *word = "./" + *word;
    words.erase(mark);
  }
  if (words.empty() || (words.front() != "verify" && words.front() != "measure" && words.front() != "analyse"))
    return words;
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (words[i].starts_with("--json=")) words[i] = "--json-file=" + words[i].substr(7);
    if (words[i] == "--json" && i + 1 < words.size() && words[i + 1].ends_with(".json")) words[i] = "--json-file";
  }
  return words;
}

/// Where to read on.
std::string with_help(const std::string& message, const std::string& command) {
  return message + (message.ends_with('?') ? " See" : "; see") + " 'partscribe help" +
         (command.empty() ? "" : " " + command) + "'";
}

/// What is wrong with a word that the parser knows no place for; empty if there is none.
std::string about_unknown_word(const CLI::App& command) {
  const auto left = command.remaining();
  if (left.empty()) return {};
  const auto option =
      std::find_if(left.begin(), left.end(), [](const std::string& word) { return word.starts_with('-'); });
  if (option == left.end()) return "found '" + left.front() + "' where nothing more was expected";
  std::error_code ignored;
  if (std::filesystem::is_regular_file(*option, ignored))
    return "found '" + *option + "', which reads as an option; write ./" + *option + " for the file";
  std::vector<std::string> names;
  for (const auto* known : command.get_options())
    for (const auto& name : known->get_lnames()) names.push_back("--" + name);
  const std::string given = option->substr(0, option->find('='));
  return "there is no option " + given + did_you_mean(given, names);
}

int fail(const Error& error) {
  std::fprintf(stderr, "partscribe: %s\n", printable(one_line(error.message)).c_str());
  return static_cast<int>(error.kind);
}

/// The program and those that it uses, a line each.
std::string versions(const std::string& own) {
  Context context;
  const auto openscad = openscad_version({}, context);
  return "partscribe " + own + "\nOpenSCAD " +
         (openscad ? *openscad + ", " + find_program("openscad").string() : "is missing: no script can be verified") +
         "\nOpenCASCADE " + occt_version();
}

/// "help --man", "help --markdown COMMAND" and "help --completion SHELL": the exit code, or nothing if something else
/// was asked for.
std::optional<int> print_manual(const std::vector<Command>& commands, const std::string& version,
                                const std::vector<std::string>& words) {
  const std::array<std::string_view, 3> known = {"--man", "--markdown", "--completion"};
  if (words.size() < 2 || words[0] != "help" || std::find(known.begin(), known.end(), words[1]) == known.end())
    return std::nullopt;
  Manual manual{version, program_help, program_footer, shared_options(), {}};
  for (const auto& command : commands)
    manual.commands.push_back({command.name, command.summary, command.help, declared_by(command)});
  if (words[1] == "--man") {
    std::fputs(manual_page(manual).c_str(), stdout);
    return 0;
  }
  if (words[1] == "--markdown") {
    const std::string name = words.size() > 2 ? words[2] : "nothing";
    const auto command = std::find_if(manual.commands.begin(), manual.commands.end(),
                                      [&](const CommandManual& one) { return one.name == name; });
    if (command == manual.commands.end())
      return fail(usage_error("help --markdown: expected a command, found '" + name + "'"));
    std::fputs(command_markdown(*command).c_str(), stdout);
    return 0;
  }
  const std::string shell = words.size() > 2 ? words[2] : "nothing";
  const auto text = completion(manual, shell);
  if (!text) return fail(text.error());
  std::fputs(text->c_str(), stdout);
  return 0;
}

}  // namespace

std::string Arguments::noted(Declared declared) {
  declared_.push_back(std::move(declared));
  return wrapped(declared_.back().help);
}

void Arguments::flag(bool& target, const std::string& name, const std::string& help) {
  app_.add_flag(name, target, noted({name, "", help, Declared::Takes::nothing}));
}

void Arguments::text(std::string& target, const std::string& name, const std::string& value_name,
                     const std::string& help) {
  app_.add_option(name, target, noted({name, value_name, help, Declared::Takes::word}))->type_name(value_name);
}

void Arguments::choice(std::string& target, const std::string& name, const std::vector<std::string>& words,
                       const std::string& help) {
  std::string all;
  for (const auto& word : words) all += (all.empty() ? "" : "|") + word;
  choice(target, name, all, words, {}, help);
}

void Arguments::choice(std::string& target, const std::string& name, const std::string& value_name,
                       const std::vector<std::string>& words, const Others& others, const std::string& help) {
  Declared declared{name, value_name, help, Declared::Takes::word, words};
  declared.other_words = !others.what.empty();
  const auto shown = noted(std::move(declared));
  app_.add_option(name, target, shown)->type_name(value_name)->check([words, others](const std::string& text) {
    const bool known = !others.what.empty() && others.known(text);
    if (known || std::find(words.begin(), words.end(), text) != words.end()) return std::string();
    std::string all;
    for (const auto& word : words) all += (all.empty() ? "" : ", ") + word;
    if (!others.what.empty()) all += ", or " + others.what;
    return "expected one of " + all + ", found '" + text + "'" + did_you_mean(text, words);
  });
}

void Arguments::number(std::optional<double>& target, const std::string& name, const std::string& value_name,
                       double low, double high, const std::string& help) {
  app_.add_option_function<std::string>(
          name,
          [&target, name, low, high](const std::string& text) {
            double value = 0;
            const auto complaint = parse_into(value, text, low, high);
            if (!complaint.empty()) throw CLI::ValidationError(name, complaint);
            target = value;
          },
          noted({name, value_name, help, Declared::Takes::number, {}, false, low, high}))
      ->type_name(value_name);
}

void Arguments::number(double& target, const std::string& name, const std::string& value_name, double low, double high,
                       const std::string& help) {
  app_.add_option_function<std::string>(
          name,
          [&target, name, low, high](const std::string& text) {
            const auto complaint = parse_into(target, text, low, high);
            if (!complaint.empty()) throw CLI::ValidationError(name, complaint);
          },
          noted({name, value_name, help, Declared::Takes::number, {}, false, low, high}))
      ->type_name(value_name);
}

void Arguments::count(int& target, const std::string& name, const std::string& value_name, int low, int high,
                      const std::string& help) {
  app_.add_option_function<std::string>(
          name,
          [&target, name, low, high](const std::string& text) {
            double value = 0;
            auto complaint = parse_into(value, text, low, high);
            if (complaint.empty() && value != static_cast<int>(value))
              complaint = "expected a whole number, found '" + text + "'";
            if (!complaint.empty()) throw CLI::ValidationError(name, complaint);
            target = static_cast<int>(value);
          },
          noted({name,
                 value_name,
                 help,
                 Declared::Takes::count,
                 {},
                 false,
                 static_cast<double>(low),
                 static_cast<double>(high)}))
      ->type_name(value_name);
}

void Arguments::path(Path& target, const std::string& name, const std::string& value_name, const std::string& help,
                     const std::string& letter) {
  Declared declared{name, value_name, help, value_name == "DIR" ? Declared::Takes::folder : Declared::Takes::file};
  declared.letter = letter;
  app_.add_option_function<std::string>(
          letter.empty() ? name : letter + "," + name, [&target](const std::string& text) { target = text; },
          noted(std::move(declared)))
      ->type_name(value_name);
}

void Arguments::list(std::vector<std::string>& target, const std::string& name, const std::string& value_name,
                     const std::vector<std::string>& words, const std::string& help) {
  app_.add_option_function<std::string>(
          name,
          [&target](const std::string& text) {
            for (std::size_t begin = 0; begin <= text.size();) {
              const auto end = std::min(text.find(',', begin), text.size());
              target.push_back(text.substr(begin, end - begin));
              begin = end + 1;
            }
          },
          noted({name, value_name, help, Declared::Takes::list, words}))
      ->type_name(value_name);
}

void Arguments::paths(std::vector<Path>& target, const std::string& name, const std::string& help) {
  app_.add_option_function<std::vector<std::string>>(
          name, [&target](const std::vector<std::string>& texts) { target.assign(texts.begin(), texts.end()); },
          noted({name, "", help, Declared::Takes::file, {}, true}))
      ->type_name("")
      ->required();
}

void Arguments::operand(Path& target, const std::string& name, const std::string& help) {
  app_.add_option_function<std::string>(
          name, [&target](const std::string& text) { target = text; }, noted({name, "", help, Declared::Takes::file}))
      ->type_name("")
      ->required();
}

std::vector<Declared> declared_by(const Command& command) {
  CLI::App app;
  Arguments arguments(app);
  command.declare(arguments);
  return arguments.declared();
}

std::vector<Declared> shared_options() {
  CLI::App app;
  Arguments arguments(app);
  SharedOptions options;
  declare_shared(arguments, options);
  return arguments.declared();
}

namespace {

/// Whether something that was printed did not arrive. A reader that went away wanted no more.
bool output_was_lost() {
  if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return false;
  pollfd output{STDOUT_FILENO, POLLOUT, 0};
  return ::poll(&output, 1, 0) < 1 || !(output.revents & POLLERR);
}

/// Lines are added to a log, and must not be to what the command reads.
bool log_is_read(const CLI::App& command, const Path& log) {
  std::error_code missing;
  for (const auto* option : command.get_options())
    if (!log.empty() && option->get_positional())
      for (const auto& given : option->results())
        if (std::filesystem::equivalent(given, log, missing)) return true;
  return false;
}

int run_words(int argc, const char* const* argv, const std::vector<Command>& commands, const std::string& version) {
  CLI::App app(program_help, "partscribe");
  app.set_version_flag(
      "--version", [&] { return versions(version); }, "print its version, and those of the CAD programs that it uses");
  app.footer(program_footer);
  app.get_formatter()->column_width(28);
  SharedOptions shared;
  for (const auto& command : commands) {
    Arguments arguments(*app.add_subcommand(command.name, command.summary));
    command.declare(arguments);
    declare_shared(arguments, shared);
  }
  try {
    if (argc <= 1) {
      std::fputs(app.help().c_str(), stdout);
      return 0;
    }
    if (const auto printed = print_manual(commands, version, {argv + 1, argv + argc})) return *printed;
    auto words = words_of(argc, argv);
    std::string list;
    std::vector<std::string> names = {"help"};
    for (const auto& command : commands)
      list += (list.empty() ? "" : ", ") + command.name, names.push_back(command.name);
    if (!words.empty() && !words.front().starts_with('-') &&
        std::find(names.begin() + 1, names.end(), words.front()) == names.end())
      return fail(usage_error(with_help(
          "expected one of " + list + ", found '" + words.front() + "'" + did_you_mean(words.front(), names), "")));
    std::reverse(words.begin(), words.end());  // as the parser wants them
    app.parse(words);
  } catch (const CLI::CallForHelp&) {
    for (const auto& command : commands) {
      auto* sub = app.get_subcommand(command.name);
      if (!sub->parsed()) continue;
      sub->description("partscribe " + command.name + ": " + command.summary + "\n\n" + command.help + "\n");
      std::fputs(sub->help("partscribe").c_str(), stdout);
      return 0;
    }
    std::fputs(app.help().c_str(), stdout);
    return 0;
  } catch (const CLI::CallForVersion& call) {
    std::printf("%s\n", call.what());
    return 0;
  } catch (const CLI::ParseError& error) {
    std::string given, what = about_unknown_word(app);
    for (const auto& command : commands)
      if (const auto* sub = app.get_subcommand(command.name); sub->parsed())
        given = command.name, what = about_unknown_word(*sub);
    return fail(usage_error(with_help(what.empty() ? one_line(error.what()) : what, given)));
  }
  for (const auto& command : commands) {
    const auto* parsed = app.get_subcommand(command.name);
    if (!parsed->parsed()) continue;
    if (log_is_read(*parsed, shared.log))
      return fail(usage_error("--log " + shared.log.string() + " is read by this command; give another name"));
    try {
      Session session(shared, version);
      if (auto started = session.start(); !started) return fail(started.error());
      const auto result = command.run(session);
      session.finish_stage();
      if (!result) {
        if (session.options.json) session.note(result.error().message);
        return fail(result.error());
      }
      return result.value();
    } catch (const std::bad_alloc&) {
      return fail({"out of memory in '" + command.name + "': use fewer points or a machine with more memory",
                   ErrorKind::stopped});
    } catch (const std::exception& error) {
      return fail({"internal error in '" + command.name + "': " + error.what() + "; please report it with the input",
                   ErrorKind::stopped});
    }
  }
  return fail(usage_error("expected a command, found none: see 'partscribe --help'"));
}

}  // namespace

int run_program(int argc, const char* const* argv, const std::vector<Command>& commands, const std::string& version) {
  const int code = run_words(argc, argv, commands, version);
  if (code >= static_cast<int>(ErrorKind::usage) || !output_was_lost()) return code;
  return fail({"standard output cannot be written: its disk is full, or it is closed", ErrorKind::stopped});
}

}  // namespace partscribe::cli
