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
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <mutex>
#include <new>
#include <sstream>
#include <type_traits>

#include "core/number.h"
#include "core/process.h"
#include "verify/exchange/brep_distance.h"
#include "verify/exchange/read_brep.h"

namespace partscribe::verify {
namespace {

constexpr const char* command = "read-brep";
constexpr int out_of_memory = 99;  // exit code of the reader
constexpr std::string_view magic = "partscribe brep 1\n";

// ---- What the reading process hands back: numbers as they lie in memory, for both ends are one program. ----

class ByteWriter {
 public:
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void put(const T& value) { bytes_.append(reinterpret_cast<const char*>(&value), sizeof value); }
  void put(const std::string& text) {
    put(static_cast<std::uint64_t>(text.size()));
    bytes_ += text;
  }
  void put(const Vec3& v) {
    for (int k = 0; k < 3; ++k) put(v[k]);
  }
  template <class T>
  void put(const std::vector<T>& list) {
    put(static_cast<std::uint64_t>(list.size()));
    for (const auto& item : list) put(item);
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_{magic};
};

/// The same in the same order; `whole()` is false once something was missing.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : rest_(bytes) {
    whole_ = bytes.starts_with(magic);
    if (whole_) rest_.remove_prefix(magic.size());
  }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void get(T& value) {
    const std::string_view bytes = next(sizeof value);
    if (whole_) std::memcpy(&value, bytes.data(), sizeof value);
  }
  void get(std::string& text) {
    std::uint64_t size = 0;
    get(size);
    text = next(size);
  }
  void get(Vec3& v) {
    for (int k = 0; k < 3; ++k) get(v[k]);
  }
  template <class T>
  void get(std::vector<T>& list) {
    std::uint64_t size = 0;
    get(size);
    whole_ = whole_ && size <= rest_.size();  // an item takes at least one byte
    if (!whole_) return;
    list.resize(size);
    for (auto& item : list) get(item);
  }
  bool whole() const { return whole_; }

 private:
  std::string_view rest_;
  bool whole_ = true;

  std::string_view next(std::uint64_t size) {
    whole_ = whole_ && size <= rest_.size();
    if (!whole_) return {};
    const std::string_view bytes = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return bytes;
  }
};

/// One list of what is handed over, for both directions: `pass` is put or get.
template <class Reading, class Pass>
void each_field(Reading& reading, const Pass& pass) {
  auto& e = reading.evaluation;
  pass(e.backend), pass(e.program), pass(e.version);
  pass(e.mesh.vertices), pass(e.mesh.triangles);
  pass(e.solid), pass(e.error), pass(e.failed), pass(e.complaints);
  pass(e.gap.width), pass(e.gap.kind), pass(e.gap.place);
  pass(reading.body);
}

std::string to_bytes(const Result<BrepReading>& result) {
  ByteWriter writer;
  writer.put(result.ok());
  if (result.ok()) {
    each_field(*result, [&](const auto& field) { writer.put(field); });
  } else {
    writer.put(result.error().kind);
    writer.put(result.error().message);
  }
  return writer.take();
}

std::optional<Result<BrepReading>> from_bytes(std::string_view bytes) {
  ByteReader reader(bytes);
  bool ok = false;
  reader.get(ok);
  BrepReading reading;
  Error error;
  if (ok) {
    each_field(reading, [&](auto& field) { reader.get(field); });
  } else {
    reader.get(error.kind);
    reader.get(error.message);
  }
  if (!reader.whole()) return std::nullopt;
  if (!ok) return Result<BrepReading>(std::move(error));
  return Result<BrepReading>(std::move(reading));
}

// ---- Who reads.
// -------------------------------------------------------------------------------------------------------

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
Result<Evaluation> no_result(const char* kind, const Path& path, const EvaluateOptions& options,
                             const ProcessOutput& run, const std::string& program) {
  if (run.exit_code == out_of_memory)
    return Error{
        "OpenCASCADE needs more than " + print_number(options.memory_mb) + " MB for '" + path.filename().string() + "'",
        ErrorKind::stopped};
  if (run.exit_code <= 128)
    return Error{"the reader '" + program + "' ended with exit code " + std::to_string(run.exit_code) + " over '" +
                     path.filename().string() + "': " + last_line_of(run.err) + "; is it of another version?",
                 ErrorKind::missing_program};
  Evaluation evaluation;
  evaluation.backend = kind;
  evaluation.program = "OpenCASCADE";
  evaluation.seconds = run.seconds;
  evaluation.failed = true;
  evaluation.complaints.push_back("OpenCASCADE crashed over the file, by signal " +
                                  std::to_string(run.exit_code - 128));
  return evaluation;
}

Result<Evaluation> evaluate_apart(const char* kind, const Path& path, const EvaluateOptions& options,
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
  const auto run = run_confined({program.string(), command, kind, file.string(), answer.string(),
                                 print_number(options.tolerance), print_number(options.scanned_size)},
                                {options.seconds, options.memory_mb}, {{file}, {folder->path()}}, context);
  if (!run.ok()) return run.error();
  if (run->timed_out)
    return Error{"OpenCASCADE did not finish " + shown + " within " + print_number(options.seconds) + " s",
                 ErrorKind::stopped};
  if (run->exit_code != 0) return no_result(kind, path, options, *run, program.string());
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
  return evaluate_apart("iges", path, options, context);
}

Result<Evaluation> evaluate_step(const Path& path, const EvaluateOptions& options, Context& context) {
  return evaluate_apart("step", path, options, context);
}

std::string occt_version() { return OCC_VERSION_COMPLETE; }

std::optional<int> serve_as_reader(int count, const char* const* arguments) {
  if (count < 2 || std::strcmp(arguments[1], command) != 0) return std::nullopt;
  EvaluateOptions options;
  const bool understood =
      count == 7 && parse(arguments[5], options.tolerance) && parse(arguments[6], options.scanned_size);
  if (!understood) {
    std::fprintf(stderr, "%s is started by the program itself\n", command);
    return static_cast<int>(ErrorKind::usage);
  }
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // nobody waits for the answer of an orphan
  std::set_terminate(end_by_exception);
  const bool iges = std::strcmp(arguments[2], "iges") == 0;
  try {
    const auto written = write_file(arguments[4], to_bytes((iges ? read_iges : read_step)(arguments[3], options)));
    return written.ok() ? 0 : static_cast<int>(ErrorKind::stopped);
  } catch (const std::bad_alloc&) {
    return out_of_memory;
  }
}

}  // namespace partscribe::verify
