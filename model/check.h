/// Decides whether a model makes sense; alone makes the CheckedModel that backends accept.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "model/model.h"

namespace partscribe::model {

/// A model that passed check(): names unique and known, references backward, values in their domains, sketches
/// closed and simple, meshes consistent.
class CheckedModel {
 public:
  const Model& operator*() const { return model_; }
  const Model* operator->() const { return &model_; }

 private:
  explicit CheckedModel(Model model) : model_(std::move(model)) {}
  friend struct Check;
  Model model_;
};

/// Everything that is wrong, one line each, with the name of the object or parameter.
struct Complaints {
  std::vector<std::string> lines;
};

/// Reports all complaints at once.
std::variant<CheckedModel, Complaints> check(Model model);

/// As check(), for callers whose model must be right; a complaint becomes one bad_input error.
Result<CheckedModel> checked(Model model, const std::string& where);

}  // namespace partscribe::model
