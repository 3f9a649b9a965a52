#include "verify/evaluate/run_occt.h"

#include <dlfcn.h>
#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <BinTools.hxx>
#include <Standard_Failure.hxx>
#include <Standard_OutOfMemory.hxx>
#include <Standard_Version.hxx>
#include <TopoDS_Shape.hxx>
#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <mutex>
#include <new>
#include <sstream>

#include "core/number.h"
#include "core/process.h"
#include "verify/evaluate/alpha1.h"
#include "verify/evaluate/brep_bytes.h"
#include "verify/exchange/brep_distance.h"
#include "verify/exchange/read_brep.h"

namespace partscribe::verify {
namespace {

constexpr const char* command = "read-brep";
constexpr int out_of_memory = 99;  // exit code of the reader

/// Who reads a kind of file.
struct Reader {
  const char* kind;
  const char* program;
  Result<BrepReading> (*read)(const Path& path, const EvaluateOptions& options);
  bool sees_folder = false;  ///< and not only the file
};
constexpr std::array readers = {Reader{"iges", "OpenCASCADE", read_iges}, Reader{"step", "OpenCASCADE", read_step},
                                Reader{"alpha1", scl_interpreter, read_alpha1, true}};

/// The library that holds this code, if it is none of the program itself: the Python module.
Path own_library() {
  Dl_info info{};
  if (::dladdr(reinterpret_cast<const void*>(&own_library), &info) == 0 || !info.dli_fname) return {};
  Path file(info.dli_fname);
  return file.is_absolute() ? file : Path();
}

/// The program partscribe: this one if it is, else the one beside the library or the program that holds this code, else
/// the one on PATH.
Path reader_program() {
  const auto beside = [](const Path& file) { return find_program((file.parent_path() / "partscribe").string()); };
  char name[4096];
  const auto length = ::readlink("/proc/self/exe", name, sizeof name);
  if (length > 0) {
    std::string_view own(name, static_cast<std::size_t>(length));
    constexpr std::string_view gone = " (deleted)";  // replaced while it runs; what runs can still be started
    if (own.ends_with(gone)) own.remove_suffix(gone.size());
    const Path self(own);
    if (self.filename() == "partscribe") return "/proc/self/exe";
    if (const Path library = own_library(); !library.empty())
      if (Path program = beside(library); !program.empty()) return program;
    if (Path program = beside(self); !program.empty()) return program;
  }
  return find_program("partscribe");
}

std::string last_line_of(const std::string& text) {
  std::string last;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (!line.empty()) last = line;
  return last;
}

std::shared_ptr<const BrepDistance> exact_of(const std::string& body) {
  if (body.empty()) return nullptr;
  static std::mutex one_at_a_time;  // of OpenCASCADE's parts only the meshing is known to be safe on several threads
  const std::lock_guard lock(one_at_a_time);
  try {
    std::istringstream bytes(body, std::ios::binary);
    TopoDS_Shape shape;
    BinTools::Read(shape, bytes);
    return BrepDistance::make(shape);
  } catch (const Standard_Failure&) {
    return nullptr;
  }
}

/// What a run of the reader that brought no result says about the file, or about the reader.
Result<Evaluation> no_result(const Reader& reader, const Path& path, const EvaluateOptions& options,
                             const ProcessOutput& run, const std::string& program) {
  if (run.exit_code == out_of_memory)
    return Error{std::string(reader.program) + " needs more than " + print_number(options.memory_mb) + " MB for '" +
                     path.filename().string() + "'",
                 ErrorKind::stopped};
  if (run.exit_code <= 128)
    return Error{"the reader '" + program + "' ended with exit code " + std::to_string(run.exit_code) + " over '" +
                     path.filename().string() + "': " + last_line_of(run.err) + "; is it of another version?",
                 ErrorKind::missing_program};
  Evaluation evaluation;
  evaluation.backend = reader.kind;
  evaluation.program = reader.program;
  evaluation.seconds = run.seconds;
  evaluation.failed = true;
  evaluation.complaints.push_back(std::string(reader.program) + " crashed over the file, by signal " +
                                  std::to_string(run.exit_code - 128));
  return evaluation;
}

Result<Evaluation> evaluate_apart(const Reader& reader, const Path& path, const EvaluateOptions& options,
                                  Context& context) {
  const std::string shown = "'" + path.filename().string() + "'";
  if (context.cancelled) return Error{"cancelled before " + shown + " was read", ErrorKind::stopped};
  const Path program = options.reader.empty() ? reader_program() : options.reader;
  if (program.empty())
    return Error{
        "program 'partscribe', which reads " + shown + " apart, was found neither beside this program nor on PATH",
        ErrorKind::missing_program};
  const auto folder = TemporaryDirectory::make();
  if (!folder) return folder.error();
  const Path file = std::filesystem::absolute(path), answer = folder->path() / "reading";
  const auto run = run_confined({program.string(), command, reader.kind, file.string(), answer.string(),
                                 print_number(options.tolerance), print_number(options.scanned_size)},
                                {options.seconds, options.memory_mb},
                                {{reader.sees_folder ? file.parent_path() : file}, {folder->path()}}, context);
  if (!run.ok()) return run.error();
  if (run->timed_out)
    return Error{
        std::string(reader.program) + " did not finish " + shown + " within " + print_number(options.seconds) + " s",
        ErrorKind::stopped};
  if (run->exit_code != 0) return no_result(reader, path, options, *run, program.string());
  const auto bytes = read_file(answer);
  if (!bytes.ok()) return bytes.error();
  auto reading = from_bytes(*bytes);
  if (!reading) return Error{"the reader '" + program.string() + "' is of another version", ErrorKind::missing_program};
  if (!reading->ok()) return reading->error();
  Evaluation evaluation = std::move((*reading)->evaluation);
  evaluation.exact = exact_of((*reading)->body);
  evaluation.seconds = run->seconds;
  return evaluation;
}

/// OpenCASCADE also throws where nothing may be thrown.
[[noreturn]] void end_by_exception() {
  try {
    if (const auto exception = std::current_exception()) std::rethrow_exception(exception);
  } catch (const Standard_OutOfMemory&) {
    ::_exit(out_of_memory);
  } catch (const std::bad_alloc&) {
    ::_exit(out_of_memory);
  } catch (...) {
  }
  std::abort();
}

bool parse(const char* text, double& value) {
  const char* end = text + std::strlen(text);
  const auto [stop, error] = std::from_chars(text, end, value);
  return error == std::errc() && stop == end;
}

}  // namespace

Result<Evaluation> evaluate_iges(const Path& path, const EvaluateOptions& options, Context& context) {
  return evaluate_apart(readers[0], path, options, context);
}

Result<Evaluation> evaluate_step(const Path& path, const EvaluateOptions& options, Context& context) {
  return evaluate_apart(readers[1], path, options, context);
}

Result<Evaluation> evaluate_alpha1(const Path& path, const EvaluateOptions& options, Context& context) {
  return evaluate_apart(readers[2], path, options, context);
}

std::string occt_version() { return OCC_VERSION_COMPLETE; }

std::optional<int> serve_as_reader(int count, const char* const* arguments) {
  if (count < 2 || std::strcmp(arguments[1], command) != 0) return std::nullopt;
  EvaluateOptions options;
  const auto reader = std::ranges::find_if(
      readers, [&](const Reader& r) { return count == 7 && std::strcmp(r.kind, arguments[2]) == 0; });
  const bool understood =
      reader != readers.end() && parse(arguments[5], options.tolerance) && parse(arguments[6], options.scanned_size);
  if (!understood) {
    std::fprintf(stderr, "%s is started by the program itself\n", command);
    return static_cast<int>(ErrorKind::usage);
  }
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // nobody waits for the answer of an orphan
  std::set_terminate(end_by_exception);
  try {
    const auto written = write_file(arguments[4], to_bytes(reader->read(arguments[3], options)));
    return written.ok() ? 0 : static_cast<int>(ErrorKind::stopped);
  } catch (const std::bad_alloc&) {
    return out_of_memory;
  }
}

}  // namespace partscribe::verify
