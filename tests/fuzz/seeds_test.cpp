/// Every committed input of the fuzzers, among them all that once showed a fault, is read or refused in little time.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>

#include "testing/fuzz/entries.h"
#include "testing/program.h"

namespace partscribe::testing {
namespace {

std::vector<Path> seeds_of(const std::string& name) {
  std::vector<Path> files;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(source_file("fuzz/seeds/" + name), none))
    files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

}  // namespace

TEST_CASE("fuzz seeds: every input of every target is read or refused without a fault, within seconds") {
  for (const auto& entry : fuzz_entries()) {
    const auto files = seeds_of(entry.name);
    INFO(entry.name);
    CHECK(!files.empty());
    for (const auto& file : files) {
      INFO(file.string());
      const auto begin = std::chrono::steady_clock::now();
      entry.run(bytes_of(file));  // a broken promise ends the program
      CHECK(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() < 10);
    }
  }
}

TEST_CASE("fuzz seeds: every folder of inputs belongs to a target") {
  for (const auto& folder : std::filesystem::directory_iterator(source_file("fuzz/seeds"))) {
    const auto of_folder = [&](const FuzzEntry& entry) { return entry.name == folder.path().filename(); };
    INFO(folder.path().string());
    CHECK(std::ranges::any_of(fuzz_entries(), of_folder));
  }
}

}  // namespace partscribe::testing
