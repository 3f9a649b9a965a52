/// Wishes and densities as people write them.
#include "cli/analyse/target.h"

#include <catch2/catch.hpp>

namespace partscribe::testing {

using namespace cli;

TEST_CASE("target: masses and volumes with their units") {
  const auto kilo = parse_target("mass=0.12kg");
  REQUIRE(kilo.ok());
  CHECK(kilo->by_mass);
  CHECK(kilo->wished == 0.12);
  CHECK(parse_target("mass=120g")->wished == Approx(0.12).epsilon(1e-15));
  CHECK(volume_for(*kilo, 2400) == Approx(50000).epsilon(1e-12));
  for (const char* text : {"volume=5cm3", "volume=5ml", "volume=5000mm3", "volume=0.005l", "volume=5e-6m3"}) {
    const auto target = parse_target(text);
    INFO(text);
    REQUIRE(target.ok());
    CHECK_FALSE(target->by_mass);
    CHECK(target->wished == Approx(5000).epsilon(1e-12));
    CHECK(volume_for(*target, 2400) == target->wished);
  }
}

TEST_CASE("target: bad_target: one line that shows how to write it") {
  for (const char* text :
       {"", "mass", "mass=", "mass=kg", "mass=0.12", "mass=0,12kg", "mass=5cm3", "volume=3kg", "mass=-1kg", "mass=0kg",
        "mass=nan kg", "mass=1e400kg", "mass=1e300kg", "weight=3kg", "mass=1kgg", "volume=1 cm3 "}) {
    const auto target = parse_target(text);
    INFO(text);
    REQUIRE_FALSE(target.ok());
    CHECK(target.error().kind == core::ErrorKind::usage);
    CHECK(target.error().message.find("mass=0.12kg") != std::string::npos);
    CHECK(target.error().message.find('\n') == std::string::npos);
  }
  CHECK(parse_target("mas=1kg").error().message.find("did you mean mass?") != std::string::npos);
  CHECK(parse_target("mass=3").error().message.find("the unit is missing") != std::string::npos);
}

TEST_CASE("target: a density is a number or the name of a material") {
  CHECK(parse_density("2700")->density == 2700);
  CHECK(parse_density("2700")->material.empty());
  CHECK(parse_density("steel")->density == 7850);
  CHECK(parse_density("steel")->material == "steel");
  for (const char* text : {"", "0", "-5", "1e9", "inf", "nan", "7850kg", "stell"}) {
    INFO(text);
    const auto density = parse_density(text);
    REQUIRE_FALSE(density.ok());
    CHECK(density.error().kind == core::ErrorKind::usage);
    CHECK(density.error().message.find("aluminium") != std::string::npos);
  }
  CHECK(parse_density("stell").error().message.find("did you mean steel?") != std::string::npos);
}

}  // namespace partscribe::testing
