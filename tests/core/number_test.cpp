// What print_number promises: the shortest text that is the value, and nothing a language could stumble over.
#include "core/number.h"

#include <catch2/catch.hpp>

#include "core/random.h"

using namespace partscribe::core;

TEST_CASE("print_number: the text reads back as the same number") {
  Random random(7);
  for (int i = 0; i < 20000; ++i) {
    const double v = (random.uniform() - 0.5) * std::pow(10.0, random.uniform(-9, 17));
    const auto back = parse_number(print_number(v));
    REQUIRE(back.has_value());
    REQUIRE(*back == v);
  }
}

TEST_CASE("print_number: no exponent in the range of parts, no negative zero") {
  CHECK(print_number(-0.0) == "0");
  CHECK(print_number(1e-6) == "0.000001");
  CHECK(print_number(123456789012345.0) == "123456789012345");
  CHECK(print_number(0.1 + 0.2) == "0.30000000000000004");
  CHECK(print_number(1e-7).find('e') != std::string::npos);
}

TEST_CASE("print_real: always has a decimal point") {
  CHECK(print_real(12) == "12.0");
  CHECK(print_real(0.5) == "0.5");
  CHECK(print_real(-3) == "-3.0");
}

TEST_CASE("print_degrees: right angles read as such") {
  CHECK(print_degrees(pi / 2) == "90");
  CHECK(print_degrees(-pi / 4) == "-45");
  CHECK(print_degrees(radians(12.345)) == "12.345");
}

TEST_CASE("snapped: a snapped value is what its text says") {
  Random random(3);
  for (int i = 0; i < 5000; ++i) {
    const double v = snapped(random.uniform(-500, 500), 0.001);
    CHECK(print_number(v).size() <= 8);
    CHECK(snapped(v, 0.001) == v);
  }
  CHECK(snapped(12.3449, 0.05) == Approx(12.35));
  CHECK(snapped(1234.0, 10) == 1230);
  CHECK(power_of_ten_below(0.0015) == 0.001);
  CHECK(power_of_ten_below(99) == 10);
  CHECK(power_of_ten_below(0.01) == 0.01);
}

TEST_CASE("parse_number: only whole, finite numbers in any locale") {
  CHECK(parse_number("+1.5") == 1.5);
  CHECK_FALSE(parse_number("1,5"));
  CHECK_FALSE(parse_number("nan"));
  CHECK_FALSE(parse_number("1e999"));
  CHECK_FALSE(parse_number(""));
  CHECK_FALSE(parse_number("12abc"));
}
