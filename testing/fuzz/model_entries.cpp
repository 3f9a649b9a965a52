// model.json.
#include <cmath>

#include "core/ensure.h"
#include "model/check.h"
#include "model/distance/distance.h"
#include "model/json.h"
#include "testing/fuzz/entries.h"

namespace partscribe::testing {

using namespace model;

void fuzz_model(std::string_view bytes) {
  auto read = read_model_json(bytes, "model.json");
  if (!read.ok()) return;
  const auto good = checked(std::move(*read), "model.json");
  if (!good.ok()) return;
  const std::string text = write_model_json(**good);
  const auto again = read_model_json(text, "model.json");
  ensure(again.ok() && write_model_json(*again) == text, "a model survives writing and reading");
  const ModelDistance distance(**good);
  const Box3 box = distance.bounds();
  for (const auto& p : {Vec3(0, 0, 0), Vec3(1, 2, 3), Vec3(-10, 5, 0.5), Vec3(box.center())}) {
    const auto hit = distance(p);
    ensure(hit.face < static_cast<int>(distance.faces().size()), "the nearest face is one of the model's");
    ensure(!std::isnan(hit.distance), "a distance is a number");
    (void)distance.bound(p);
  }
}

}  // namespace partscribe::testing
