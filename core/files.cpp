#include "core/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <set>
#include <system_error>

#include "core/temporary_directories.h"

namespace partscribe::core {
namespace {

std::string reason() { return std::strerror(errno); }

std::uint32_t rotated(std::uint32_t x, int n) { return (x >> n) | (x << (32 - n)); }

// FIPS 180-4, section 4.2.2.
constexpr std::array<std::uint32_t, 64> round_constants = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

void digest_block(const unsigned char* block, std::array<std::uint32_t, 8>& state) {
  std::array<std::uint32_t, 64> w;
  for (int i = 0; i < 16; ++i)
    w[i] = std::uint32_t(block[4 * i]) << 24 | std::uint32_t(block[4 * i + 1]) << 16 |
           std::uint32_t(block[4 * i + 2]) << 8 | block[4 * i + 3];
  for (int i = 16; i < 64; ++i) {
    const auto s0 = rotated(w[i - 15], 7) ^ rotated(w[i - 15], 18) ^ (w[i - 15] >> 3);
    const auto s1 = rotated(w[i - 2], 17) ^ rotated(w[i - 2], 19) ^ (w[i - 2] >> 10);
    w[i] = w[i - 16] + s0 + w[i - 7] + s1;
  }
  auto [a, b, c, d, e, f, g, h] = state;
  for (int i = 0; i < 64; ++i) {
    const auto t1 =
        h + (rotated(e, 6) ^ rotated(e, 11) ^ rotated(e, 25)) + ((e & f) ^ (~e & g)) + round_constants[i] + w[i];
    const auto t2 = (rotated(a, 2) ^ rotated(a, 13) ^ rotated(a, 22)) + ((a & b) ^ (a & c) ^ (b & c));
    h = g, g = f, f = e, e = d + t1, d = c, c = b, b = a, a = t1 + t2;
  }
  const std::array<std::uint32_t, 8> add = {a, b, c, d, e, f, g, h};
  for (int i = 0; i < 8; ++i) state[i] += add[i];
}

}  // namespace

Result<std::string> read_file(const Path& path, std::uint64_t max_bytes) {
  // A pipe would let us wait for somebody who writes.
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (file < 0) return bad_input(path.string() + ": cannot be opened: " + reason());
  struct stat status {};
  if (::fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(file);
    return bad_input(path.string() + ": expected a file, found something else");
  }
  const auto size = static_cast<std::uint64_t>(status.st_size);
  if (size > max_bytes) {
    ::close(file);
    return bad_input(path.string() + ": " + std::to_string(size) + " bytes are more than the limit of " +
                     std::to_string(max_bytes));
  }
  std::string bytes(size, '\0');
  std::size_t done = 0;
  while (done < bytes.size()) {
    const auto got = ::read(file, bytes.data() + done, bytes.size() - done);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    done += static_cast<std::size_t>(got);
  }
  ::close(file);
  if (done != bytes.size()) return bad_input(path.string() + ": reading stopped early: " + reason());
  return bytes;
}

Result<Done> write_file(const Path& path, std::string_view bytes) {
  const Path temporary = path.string() + ".part" + std::to_string(::getpid());
  const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) return Error{path.string() + ": cannot be written: " + reason(), ErrorKind::stopped};
  std::size_t done = 0;
  while (done < bytes.size()) {
    const auto put = ::write(file, bytes.data() + done, bytes.size() - done);
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) break;
    done += static_cast<std::size_t>(put);
  }
  const bool closed = ::close(file) == 0;
  if (done != bytes.size() || !closed || ::rename(temporary.c_str(), path.c_str()) != 0) {
    const std::string why = reason();
    ::unlink(temporary.c_str());
    return Error{path.string() + ": cannot be written: " + why, ErrorKind::stopped};
  }
  return Done{};
}

std::string sha256(std::string_view bytes) {
  std::array<std::uint32_t, 8> state = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                        0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  std::size_t i = 0;
  for (; i + 64 <= bytes.size(); i += 64) digest_block(data + i, state);
  std::string tail(bytes.substr(i));
  tail += '\x80';
  while (tail.size() % 64 != 56) tail += '\0';
  const std::uint64_t bits = std::uint64_t(bytes.size()) * 8;
  for (int k = 7; k >= 0; --k) tail += static_cast<char>(bits >> (8 * k));
  for (std::size_t k = 0; k < tail.size(); k += 64)
    digest_block(reinterpret_cast<const unsigned char*>(tail.data()) + k, state);
  std::string text;
  char word[9];
  for (const auto value : state) {
    std::snprintf(word, sizeof word, "%08x", value);
    text += word;
  }
  return text;
}

namespace {

/// The temporary folders that exist, for an end at which nobody cleans up.
struct Made {
  std::mutex access;
  std::set<Path> paths;
};
Made& made_folders() {
  static Made* const made = new Made;  // outlives all that may still make one
  return *made;
}

}  // namespace

void remove_temporary_directories() {
  Made& made = made_folders();
  const std::lock_guard lock(made.access);
  std::error_code ignored;
  for (const auto& path : made.paths) std::filesystem::remove_all(path, ignored);
}

Result<TemporaryDirectory> TemporaryDirectory::make() {
  std::error_code failure;
  const Path parent = std::filesystem::temp_directory_path(failure);
  std::string pattern = (parent / "partscribe-XXXXXX").string();
  if (failure || ::mkdtemp(pattern.data()) == nullptr)
    return Error{"no temporary folder can be made in " + parent.string() + ": " +
                     (failure ? failure.message() : reason()) + "; TMPDIR names another place",
                 ErrorKind::stopped};
  Made& made = made_folders();
  const std::lock_guard lock(made.access);
  made.paths.insert(pattern);
  return TemporaryDirectory(Path(pattern));
}

TemporaryDirectory::TemporaryDirectory() {
  auto made = make();
  ensure(made.ok(), "a temporary directory can be made");
  std::swap(path_, made->path_);
}

TemporaryDirectory::TemporaryDirectory(TemporaryDirectory&& other) noexcept { std::swap(path_, other.path_); }

TemporaryDirectory::~TemporaryDirectory() {
  if (path_.empty()) return;
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
  Made& made = made_folders();
  const std::lock_guard lock(made.access);
  made.paths.erase(path_);
}

}  // namespace partscribe::core
