// Files appear whole, and content has one name.
#include "core/files.h"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>

#include "core/context.h"
#include "core/parallel.h"

using namespace partscribe::core;

TEST_CASE("sha256: certified values") {
  CHECK(sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(sha256(std::string(1000000, 'a')) == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST_CASE("write_file: reads back equal and leaves nothing else behind") {
  const TemporaryDirectory folder;
  const std::string bytes("a\0b\n", 4);
  REQUIRE(write_file(folder.path() / "x.bin", bytes).ok());
  const auto back = read_file(folder.path() / "x.bin");
  REQUIRE(back.ok());
  CHECK(*back == bytes);
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) count += entry.exists();
  CHECK(count == 1);
}

TEST_CASE("write_file: a folder that does not exist is one line of bad news") {
  const auto result = write_file("/nonexistent/folder/file", "x");
  REQUIRE_FALSE(result.ok());
  CHECK(result.error().message.find("/nonexistent/folder/file: cannot be written") == 0);
  CHECK(result.error().message.find('\n') == std::string::npos);
}

TEST_CASE("read_file: a folder and a missing file are told apart from files") {
  CHECK(read_file("/tmp").error().message.find("expected a file") != std::string::npos);
  const TemporaryDirectory folder;
  REQUIRE(::mkfifo((folder.path() / "pipe").c_str(), 0600) == 0);  // nobody writes into it
  CHECK(read_file(folder.path() / "pipe").error().message.find("expected a file") != std::string::npos);
  CHECK(read_file("/no/such/file").error().kind == ErrorKind::bad_input);
}

TEST_CASE("temporary directory: where none can be made that is an error, not the end") {
  const char* before = std::getenv("TMPDIR");
  const std::string kept = before ? before : "";
  ::setenv("TMPDIR", "/nonexistent/folder", 1);
  const auto made = TemporaryDirectory::make();
  if (before)
    ::setenv("TMPDIR", kept.c_str(), 1);
  else
    ::unsetenv("TMPDIR");
  REQUIRE_FALSE(made.ok());
  CHECK(made.error().kind == ErrorKind::stopped);
  CHECK(made.error().message.find("TMPDIR") != std::string::npos);
}

TEST_CASE("parallel_for: every index once, whatever the number of threads") {
  for (const int threads : {1, 2, 7}) {
    std::vector<int> hits(10007, 0);
    parallel_for(hits.size(), threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) ++hits[i];
    });
    CHECK(std::all_of(hits.begin(), hits.end(), [](int h) { return h == 1; }));
  }
  CHECK_THROWS_AS(parallel_for(
                      100, 3, [](std::size_t, std::size_t) { throw std::runtime_error("x"); }, 1),
                  std::runtime_error);
}
