/// Work of C++ without the interpreter's lock: Python hears of its progress, may stop it, and gets its errors.
#pragma once

#include <pybind11/pybind11.h>

#include <functional>
#include <optional>
#include <string>

#include "cli/session.h"
#include "core/result.h"

namespace partscribe::python {

namespace py = pybind11;

/// Raises the class of partscribe.errors that belongs to the kind.
[[noreturn]] void raise(const core::Error& error);

/// Text that may hold the bytes of a file's name, as Python has those (surrogateescape).
py::str text(const std::string& bytes);

/// Calls `work` on a thread of its own and waits for it. `progress(stage, share)` may be None. What `progress` or a
/// signal's handler raises stops the work and is raised here. Warnings of the session become warnings of Python.
void run_apart(const cli::SharedOptions& options, const py::object& progress,
               const std::function<void(cli::Session&)>& work);

/// The same for work with a result; its error is raised.
template <class T>
T run(const cli::SharedOptions& options, const py::object& progress,
      const std::function<core::Result<T>(cli::Session&)>& work) {
  std::optional<core::Result<T>> result;
  run_apart(options, progress, [&](cli::Session& session) { result.emplace(work(session)); });
  if (!result->ok()) raise(result->error());
  return std::move(*result).value();
}

}  // namespace partscribe::python
