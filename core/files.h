/// Whole files: read at once, written whole or not at all, and named by their content.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/result.h"

namespace partscribe::core {

using Path = std::filesystem::path;

/// All bytes of a file; an error names the file and says why.
Result<std::string> read_file(const Path& path, std::uint64_t max_bytes = 16ull << 30);

/// Writes to a temporary name beside `path` and renames it, so that nobody ever sees half a file. Error: stopped.
Result<Done> write_file(const Path& path, std::string_view bytes);

/// SHA-256 as 64 hexadecimal digits.
std::string sha256(std::string_view bytes);

/// A new empty directory that is removed with its contents when the object ends.
class TemporaryDirectory {
 public:
  /// An error if the system has no room for it, or no right to make it.
  static Result<TemporaryDirectory> make();

  TemporaryDirectory();  ///< where the lack of one is the end of the program: for tests
  ~TemporaryDirectory();
  TemporaryDirectory(TemporaryDirectory&& other) noexcept;
  TemporaryDirectory& operator=(TemporaryDirectory&&) = delete;
  const Path& path() const { return path_; }

 private:
  explicit TemporaryDirectory(Path path) : path_(std::move(path)) {}
  Path path_;
};

}  // namespace partscribe::core
