/// Models of tests that must be right.
#pragma once

#include <catch2/catch.hpp>

#include "model/check.h"

namespace partscribe::testing {

/// Fails the test, with the complaints, if there are any.
inline model::CheckedModel checked_model(const model::Model& model) {
  auto result = model::checked(model, model.name);
  INFO(model.name << ": " << (result.ok() ? "" : result.error().message));
  REQUIRE(result.ok());
  return std::move(result).value();
}

}  // namespace partscribe::testing
