/// The architecture, read from the #include lines.
#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <sstream>

#include "testing/program.h"

namespace partscribe::testing {
namespace {

const std::map<std::string, std::set<std::string>> allowed = {
    {"core", {"core"}},
    {"geometry", {"core", "geometry"}},
    {"model", {"core", "geometry", "model"}},
    {"scan", {"core", "geometry", "model", "scan"}},
    {"fit", {"core", "geometry", "model", "fit"}},
    {"codegen", {"core", "geometry", "model", "codegen"}},
    {"verify", {"core", "geometry", "model", "verify"}},
    {"cli", {"core", "geometry", "model", "scan", "fit", "codegen", "verify", "cli"}},
};

/// What stands between the delimiters of every #include line: <x> or "x".
std::vector<std::string> includes_of(const Path& file, char open, char close) {
  std::vector<std::string> result;
  std::istringstream lines(bytes_of(file));
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("#include")) continue;
    const auto begin = line.find(open);
    if (begin == std::string::npos) continue;
    const auto end = line.find(close, begin + 1);
    if (end != std::string::npos) result.push_back(line.substr(begin + 1, end - begin - 1));
  }
  return result;
}

/// Complaints about one file, as its text would have it.
std::vector<std::string> broken_rules(const std::string& folder, const Path& file) {
  std::vector<std::string> complaints;
  for (const auto& included : includes_of(file, '"', '"')) {
    const auto slash = included.find('/');
    const std::string from = slash == std::string::npos ? "." : included.substr(0, slash);
    if (!allowed.at(folder).count(from)) complaints.push_back(file.string() + " includes " + included);
  }
  if (file.extension() == ".h")
    for (const auto& included : includes_of(file, '<', '>')) {
      const bool heavy = included.starts_with("CGAL/") || included.starts_with("ceres/") ||
                         included.starts_with("CLI/") || included.starts_with("png") ||
                         included == "nlohmann/json.hpp" || included.ends_with(".hxx");
      if (heavy) complaints.push_back(file.string() + " is a header and includes " + included);
    }
  return complaints;
}

/// What tests and measurements may include: `testing` besides the program itself; nothing from one another.
std::vector<std::string> foreign_includes(const std::string& folder, const Path& file) {
  std::vector<std::string> complaints;
  for (const auto& included : includes_of(file, '"', '"')) {
    const auto slash = included.find('/');
    const std::string from = slash == std::string::npos ? "." : included.substr(0, slash);
    const bool own = folder == "bench" && (from == "bench" || from == ".");
    if (!allowed.count(from) && from != "testing" && !own)
      complaints.push_back(file.string() + " includes " + included);
  }
  return complaints;
}

/// Whether a test of the subfolder is called after a source file there: "kd_tree_test", "register_borders_test"; in
/// `core` also after a page of docs that it reads: "paper_rows_test".
bool called_after_a_source(const Path& test, const Path& subfolder) {
  std::string name = test.stem().string();
  if (!name.ends_with("_test")) return false;
  name.resize(name.size() - 5);
  for (std::size_t end = name.size(); end != std::string::npos && end > 0; end = name.rfind('_', end - 1)) {
    const Path source = source_file((subfolder / name.substr(0, end)).string());
    for (const char* suffix : {".h", ".cpp"})
      if (std::filesystem::exists(source.string() + suffix)) return true;
    if (subfolder == "core" && std::filesystem::exists(source_file("docs/" + name.substr(0, end) + ".md"))) return true;
  }
  return false;
}

bool is_source(const Path& file) { return file.extension() == ".h" || file.extension() == ".cpp"; }

/// The namespaces of the project that a file opens.
std::set<std::string> namespaces_of(const Path& file) {
  std::set<std::string> result;
  std::istringstream lines(bytes_of(file));
  for (std::string line; std::getline(lines, line);) {
    const auto brace = line.find(" {");
    if (line.starts_with("namespace partscribe") && brace != std::string::npos)
      result.insert(line.substr(10, brace - 10));
  }
  return result;
}

/// Complaints about the namespaces of one file: all of them are that of its folder, or within it.
std::vector<std::string> foreign_namespaces(const std::string& folder, const Path& file) {
  std::vector<std::string> complaints;
  const std::string own = "partscribe::" + folder;
  for (const auto& name : namespaces_of(file))
    if (name != own && !name.starts_with(own + "::"))
      complaints.push_back(file.string() + " opens " + name + " where " + own + " is expected");
  return complaints;
}

/// Types that a file defines outside unnamed namespaces and outside other types.
std::set<std::string> types_of(const Path& file) {
  std::set<std::string> result;
  std::istringstream lines(bytes_of(file));
  int unnamed = 0;
  std::vector<bool> open;  // of each namespace: has it no name?
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("namespace ")) open.push_back(line.starts_with("namespace {")), unnamed += open.back();
    if (line.starts_with("}  // namespace") && !open.empty()) unnamed -= open.back(), open.pop_back();
    std::size_t skip = line.starts_with("struct ") ? 7 : line.starts_with("class ") ? 6 : 0;
    if (skip > 0 && line.substr(skip).starts_with("alignas(")) skip = line.find(") ", skip) + 2;
    if (skip == 0 || unnamed > 0 || line.find('{') == std::string::npos) continue;
    const std::string name = line.substr(skip, line.find_first_of(" {", skip) - skip);
    if (name.find("::") == std::string::npos) result.insert(name);
  }
  return result;
}

}  // namespace

TEST_CASE("layers: no two files define types of one name") {
  // The linker would take the functions of one for the other, without a word.
  std::map<std::string, Path> first;
  for (const auto& [folder, below] : allowed)
    for (const auto& entry : std::filesystem::recursive_directory_iterator(source_file(folder))) {
      const auto suffix = entry.path().extension();
      if (suffix != ".h" && suffix != ".cpp") continue;
      for (const auto& type : types_of(entry.path())) {
        const auto [known, is_new] = first.emplace(type, entry.path());
        if (!is_new) FAIL_CHECK(type << " is defined in " << known->second << " and in " << entry.path());
      }
    }
  CHECK(first.count("Candidate") == 1);
}

TEST_CASE("layers: a type within an unnamed namespace is the file's own") {
  const TemporaryDirectory folder;
  const Path file = folder.path() / "types.cpp";
  REQUIRE(write_file(file,
                     "namespace a {\nnamespace {\nstruct Own {\n};\n}  // namespace\nstruct Shared {\n};\nstruct "
                     "Shared::Part {\n};\nstruct alignas(64) Wide {\n};\n}  // namespace a\n")
              .ok());
  CHECK(types_of(file) == std::set<std::string>{"Shared", "Wide"});
}

TEST_CASE("layers: every folder includes only what stands below it") {
  std::size_t files = 0;
  for (const auto& [folder, below] : allowed)
    for (const auto& entry : std::filesystem::recursive_directory_iterator(source_file(folder))) {
      const auto suffix = entry.path().extension();
      if (suffix != ".h" && suffix != ".cpp") continue;
      ++files;
      for (const auto& complaint : broken_rules(folder, entry.path())) FAIL_CHECK(complaint);
    }
  CHECK(files > 50);
}

TEST_CASE("layers: a file opens the namespace of its folder") {
  std::size_t files = 0;
  for (const auto& [folder, below] : allowed)
    for (const auto& entry : std::filesystem::recursive_directory_iterator(source_file(folder))) {
      const auto suffix = entry.path().extension();
      if ((suffix != ".h" && suffix != ".cpp") || entry.path() == source_file("core/layers.h")) continue;
      files += namespaces_of(entry.path()).empty() ? 0 : 1;
      for (const auto& complaint : foreign_namespaces(folder, entry.path())) FAIL_CHECK(complaint);
    }
  CHECK(files > 400);
}

TEST_CASE("layers: a namespace sees those of the folders below its own") {
  std::map<std::string, std::set<std::string>> told;
  std::istringstream lines(bytes_of(source_file("core/layers.h")));
  std::string name;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("namespace partscribe::")) {
      name = line.substr(22, line.find(' ', 22) - 22);
      told[name] = {name};
    }
    if (line.starts_with("using namespace ")) told[name].insert(line.substr(16, line.size() - 17));
  }
  CHECK(told == allowed);
}

TEST_CASE("layers: tests and measurements share through testing, and never include each other") {
  std::size_t files = 0;
  for (const std::string folder : {"testing", "tests", "bench"})
    for (const auto& entry : std::filesystem::recursive_directory_iterator(source_file(folder))) {
      if (!is_source(entry.path())) continue;
      ++files;
      for (const auto& complaint : foreign_includes(folder, entry.path())) FAIL_CHECK(complaint);
      if (folder == "testing")
        for (const auto& complaint : foreign_namespaces(folder, entry.path())) FAIL_CHECK(complaint);
    }
  CHECK(files > 150);
  const TemporaryDirectory folder;
  const Path file = folder.path() / "bad.cpp";
  REQUIRE(write_file(file, "#include \"bench/recovery/cases.h\"\n#include \"testing/meshes.h\"\n").ok());
  CHECK(foreign_includes("tests", file).size() == 1);
}

TEST_CASE("layers: a test is called after the file that it tests") {
  std::size_t files = 0;
  for (const auto& [folder, below] : allowed)
    for (const auto& entry : std::filesystem::recursive_directory_iterator(source_file("tests/" + folder))) {
      if (!is_source(entry.path())) continue;
      const Path subfolder = std::filesystem::relative(entry.path().parent_path(), source_file("tests"));
      if (subfolder == "cli/program") continue;  // tests of the program as a whole
      ++files;
      if (!called_after_a_source(entry.path(), subfolder))
        FAIL_CHECK(entry.path() << " is called after nothing in " << subfolder);
    }
  CHECK(files > 100);
  CHECK_FALSE(called_after_a_source("hull_test.cpp", "geometry/points"));
  CHECK_FALSE(called_after_a_source("kd_tree.cpp", "geometry/points"));
  CHECK_FALSE(called_after_a_source("paper_rows_test.cpp", "geometry/points"));
}

TEST_CASE("layers: every subfolder has its sentence in CONTRIBUTING") {
  std::set<std::string> there, told;
  for (const auto& [folder, below] : allowed)
    for (const auto& entry : std::filesystem::recursive_directory_iterator(source_file(folder)))
      if (entry.is_directory()) there.insert(std::filesystem::relative(entry.path(), source_file(".")).string());
  std::istringstream lines(bytes_of(source_file("CONTRIBUTING.md")));
  for (std::string line; std::getline(lines, line);) {
    const auto end = line.find("` | ");
    if (!line.starts_with("| `") || end == std::string::npos || line.find('/') > end) continue;
    told.insert(line.substr(3, end - 3));
    CHECK(line.size() > end + 20);
  }
  CHECK(told == there);
}

TEST_CASE("layers: an include that points upward is noticed") {
  const TemporaryDirectory folder;
  const Path file = folder.path() / "bad.h";
  REQUIRE(write_file(file, "#include \"fit/build.h\"\n#include <CGAL/Kernel.h>\n#include \"core/result.h\"\n").ok());
  CHECK(broken_rules("geometry", file).size() == 2);
  CHECK(broken_rules("cli", file).size() == 1);
}

TEST_CASE("layers: another folder's namespace is noticed") {
  const TemporaryDirectory folder;
  const Path file = folder.path() / "bad.h";
  REQUIRE(
      write_file(file, "namespace partscribe::fit {\nnamespace partscribe::fitting {\nnamespace partscribe {\n").ok());
  CHECK(foreign_namespaces("fit", file).size() == 2);
  CHECK(foreign_namespaces("scan", file).size() == 3);
}

}  // namespace partscribe::testing
