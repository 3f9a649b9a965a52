#include "model/model.h"

namespace partscribe::model {

bool Frame::identity() const { return *this == Frame{}; }

void visit_expressions(Frame& f, const std::function<void(Expr&)>& visit) {
  for (Expr* e : {&f.x, &f.y, &f.z, &f.rx, &f.ry, &f.rz}) visit(*e);
}

void visit_expressions(const Frame& f, const std::function<void(const Expr&)>& visit) {
  for (const Expr* e : {&f.x, &f.y, &f.z, &f.rx, &f.ry, &f.rz}) visit(*e);
}

Values values_of(const Model& model) {
  Values values;
  for (const auto& p : model.parameters) values[p.name] = p.value;
  return with_formulas(model, std::move(values));
}

Values with_formulas(const Model& model, Values values) {
  for (const auto& p : model.parameters)
    if (p.formula) values[p.name] = evaluate(*p.formula, values);
  return values;
}

Pose evaluate(const Frame& f, const Values& values) {
  return {rotation_from_euler({evaluate(f.rx, values), evaluate(f.ry, values), evaluate(f.rz, values)}),
          {evaluate(f.x, values), evaluate(f.y, values), evaluate(f.z, values)}};
}

}  // namespace partscribe::model
