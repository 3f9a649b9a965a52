// What the writers of scripts are given: models and templates.
#include "codegen/emit.h"
#include "codegen/template.h"
#include "model/check.h"
#include "model/json.h"
#include "testing/fuzz/entries.h"

namespace partscribe::testing {

using namespace codegen;

void fuzz_emit(std::string_view bytes) {
  auto read = read_model_json(bytes, "model.json");
  if (!read.ok()) return;
  const auto good = checked(std::move(*read), "model.json");
  if (!good.ok()) return;
  Context context;
  for (const char* backend : {"openscad", "alpha1"}) (void)emit(*good, backend, {}, context);
}

void fuzz_template(std::string_view bytes) {
  TemplateList list = template_lines({"a", "b\nc", ""});
  separate(list);
  TemplateRecord inner{{"name", "inner"}, {"list", list}};
  (void)render_template(bytes, {{"name", "x"}, {"empty", ""}, {"list", list}, {"record", inner}}, "part.scad");
}

}  // namespace partscribe::testing
