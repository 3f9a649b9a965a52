#include "python/run.h"

#include <chrono>
#include <future>
#include <mutex>
#include <vector>

namespace partscribe::python {
namespace {

constexpr std::chrono::milliseconds between_looks{50};  // at what Ctrl-C asks for

}  // namespace

py::str text(const std::string& bytes) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(bytes.data(), static_cast<Py_ssize_t>(bytes.size()), "surrogateescape"));
}

void raise(const core::Error& error) {
  const py::object type = py::module_::import("partscribe.errors").attr("of_kind")(static_cast<int>(error.kind));
  PyErr_SetObject(type.ptr(), text(error.message).ptr());
  throw py::error_already_set();
}

void run_apart(const cli::SharedOptions& options, const py::object& progress,
               const std::function<void(cli::Session&)>& work) {
  cli::Session session(options, PARTSCRIBE_VERSION);
  std::optional<py::error_already_set> raised;  // guarded by the interpreter's lock
  std::vector<std::string> warnings;
  std::mutex warning;
  const auto stop = [&](py::error_already_set&& why) {
    if (!raised) raised.emplace(std::move(why));
    session.context.cancelled = true;
  };
  session.start_within({[&](const std::string& stage, double share) {
                          if (progress.is_none() || session.context.cancelled) return;
                          const py::gil_scoped_acquire lock;
                          try {
                            progress(text(stage), share);
                          } catch (py::error_already_set& error) {
                            stop(std::move(error));
                          }
                        },
                        [&](const std::string& line) {
                          const std::lock_guard lock(warning);
                          warnings.push_back(line);
                        }});
  std::future<void> done;
  {
    const py::gil_scoped_release unlocked;
    done = std::async(std::launch::async, [&] { work(session); });
    while (done.wait_for(between_looks) != std::future_status::ready) {
      const py::gil_scoped_acquire lock;
      if (PyErr_CheckSignals() != 0) stop(py::error_already_set());
    }
  }
  if (raised) throw py::error_already_set(*raised);
  done.get();
  if (warnings.empty()) return;
  py::list lines;
  for (const auto& line : warnings) lines.append(text(line));
  py::module_::import("partscribe.errors").attr("warn")(lines);
}

}  // namespace partscribe::python
