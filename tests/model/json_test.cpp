// model.json: what is written is read back equal, and what is broken is named.
#include "model/json.h"

#include <catch2/catch.hpp>

#include "model/check.h"
#include "testing/models.h"

using namespace partscribe::model;
using namespace partscribe::testing;

TEST_CASE("model.json: every shape survives the round trip byte for byte") {
  for (const auto& model : one_of_each()) {
    const std::string text = write_model_json(model);
    const auto back = read_model_json(text, "m.json");
    REQUIRE(back.ok());
    CHECK(back->objects.back().shape == model.objects.back().shape);
    CHECK(write_model_json(*back) == text);
  }
}

TEST_CASE("model.json: bad documents give one line with the place") {
  const std::string good = write_model_json(pin());
  auto message = [](std::string text) {
    const auto result = read_model_json(text, "m.json");
    REQUIRE_FALSE(result.ok());
    CHECK(result.error().message.find('\n') == std::string::npos);
    CHECK(result.error().kind == ErrorKind::bad_input);
    return result.error().message;
  };
  auto replaced = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const auto at = text.find(from);
    REQUIRE(at != std::string::npos);
    return text.replace(at, from.size(), to);
  };
  CHECK(message("{").find("not JSON") != std::string::npos);
  CHECK(message("[]").find("expected an object") != std::string::npos);
  CHECK(message(replaced("partscribe-model", "other")).find("format") != std::string::npos);
  CHECK(message(replaced("\"version\": 1", "\"version\": 99")).find("version") != std::string::npos);
  CHECK(message(replaced("\"kind\": \"revolve\"", "\"kind\": \"spiral\"")).find("unknown shape 'spiral'") !=
        std::string::npos);
  CHECK(message(replaced("\"center_x\": [\"-\"", "\"center_x\": [\"%\"")).find("unknown operator '%'") !=
        std::string::npos);
  CHECK(message(replaced("\"units\": \"mm\"", "\"units\": \"inch\"")).find("expected 'mm'") != std::string::npos);
  std::string deep = "1";
  for (int i = 0; i < 500; ++i) deep = "[\"neg\", " + deep + "]";
  CHECK(message(replaced("\"radius\": \"round_radius\"", "\"radius\": " + deep)).find("nested too deeply") !=
        std::string::npos);
}

TEST_CASE("model.json: cutting the text anywhere never crashes and never passes") {
  const std::string good = write_model_json(link());
  for (std::size_t n = 0; n + 2 < good.size(); n += 7) CHECK_FALSE(read_model_json(good.substr(0, n), "m.json").ok());
}
