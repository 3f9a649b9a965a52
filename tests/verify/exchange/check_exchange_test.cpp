/// Claims about STEP and IGES files that are not whole: each is refused by its text, with the reason.
#include "verify/exchange/check_exchange.h"

#include <catch2/catch.hpp>

#include "core/files.h"
#include "testing/program.h"

using namespace partscribe::verify;

namespace {

std::string golden(const std::string& file) {
  const auto text = read_file(partscribe::testing::source_file("tests/golden/" + std::string(file)));
  REQUIRE(text.ok());
  return *text;
}

std::string with(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

bool says(const std::optional<std::string>& fault, const std::string& words) {
  INFO(fault.value_or("nothing"));
  CHECK(fault.has_value());
  return fault && fault->find(words) != std::string::npos;
}

}  // namespace

TEST_CASE("check exchange: every golden file is whole") {
  for (const auto& entry : std::filesystem::directory_iterator(partscribe::testing::source_file("tests/golden"))) {
    const std::string part = entry.path().filename().string();
    INFO(part);
    if (std::filesystem::exists(entry.path() / "part.step")) CHECK_FALSE(fault_of_step(golden(part + "/part.step")));
    if (std::filesystem::exists(entry.path() / "part.igs")) CHECK_FALSE(fault_of_iges(golden(part + "/part.igs")));
  }
}

TEST_CASE("check exchange: bad_step files are refused with what is wrong") {
  const std::string text = golden("box/part.step");
  for (const double share : {0.1, 0.5, 0.9, 0.999})
    CHECK(says(fault_of_step(text.substr(0, std::size_t(share * double(text.size())))), "the file ends before"));
  CHECK(says(fault_of_step(""), "does not begin"));
  CHECK(says(fault_of_step(with(text, "CLOSED_SHELL('',(#17,", "CLOSED_SHELL('',(#999999,")),
             "#999999, which is missing"));
  CHECK(says(fault_of_step(with(text, "CLOSED_SHELL('',(#17,", "CLOSED_SHELL('',(#16,")),
             "#16 refers to itself in a circle"));
  CHECK(says(fault_of_step(with(text, "(12.5,-3.25,40.)", "(NAN,-3.25,40.)")), "'NAN' stands where"));
  CHECK(says(fault_of_step(with(text, "(12.5,-3.25,40.)", "(1.E400,-3.25,40.)")), "no finite number"));
  CHECK(says(fault_of_step(with(text, "(12.5,-3.25,40.)", "(,-3.25,40.)")), "a value is missing"));
  CHECK(says(fault_of_step(with(text, "#15 = MANIFOLD_SOLID_BREP", "#14 = MANIFOLD_SOLID_BREP")),
             "#14 is defined twice"));
  CHECK_FALSE(fault_of_step(with(text, "DATA;", "DATA;\n/* a remark; with #77 = and ' in it */")));
  CHECK_FALSE(fault_of_step(with(text, "(12.5,-3.25,40.)", "(12.5,-3.25E-400,4.0E+1)")));
}

TEST_CASE("check exchange: bad_iges files are refused with what is wrong") {
  const std::string text = golden("box/part.igs");
  for (const double share : {0.1, 0.5, 0.9, 0.98}) {
    const auto fault = fault_of_iges(text.substr(0, std::size_t(share * double(text.size()))));
    INFO(fault.value_or("nothing"));
    CHECK(fault.has_value());
  }
  CHECK(says(fault_of_iges("solid\n"), "does not begin with a line of IGES"));
  CHECK(says(fault_of_iges(with(text, "514,6,5,0,", "514,6,4,0,")), "refers to an entry that is missing"));
  CHECK(says(fault_of_iges(with(text, "514,6,5,0,", "514,6,3,0,")), "refers to itself in a circle"));
  const auto line = text.find("0000045P");
  REQUIRE(line != std::string::npos);
  const auto begin = text.rfind('\n', line), end = text.find('\n', line);
  CHECK(says(fault_of_iges(text.substr(0, begin) + text.substr(end)), "lines are missing"));
  std::string windows;
  for (const char c : text) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  CHECK_FALSE(fault_of_iges(windows));
}
