#include "verify/scl/scl_evaluate.h"

#include <cmath>
#include <deque>
#include <map>
#include <set>

#include "core/lies_within.h"
#include "verify/scl/scl_natives.h"
#include "verify/scl/scl_parser.h"
#include "verify/scl/scl_value.h"

namespace partscribe::verify {
namespace {

using Kind = SclNode::Kind;

// What the stack bears with room to spare.
constexpr int max_depth = 2500;

/// Labels of one sequence, loop or procedure call; `parent` is the scope around it.
struct Scope {
  Scope* parent = nullptr;
  std::map<std::string, std::pair<std::string, SclValue>> labels;  // by lower case: spelling and value
};

struct Procedure {
  const SclNode* node = nullptr;
  const std::string* file = nullptr;
};

/// A statement's value, and whether a `return` is on its way out.
struct Flow {
  SclValue value;
  bool returned = false;
};

class Interpreter {
 public:
  Interpreter(const SclLimits& limits, Path root) : limits_(limits), root_(std::move(root)) {}

  Result<Done> run_file(const Path& path, const std::string& shown) {
    auto text = read_file(path, limits_.bytes);
    if (!text.ok()) return text.error();
    names_.push_back(shown);
    const std::string& name = names_.back();
    auto forms = parse_scl(*text, name);
    if (!forms.ok()) return forms.error();
    trees_.push_back(std::move(*forms));
    const std::vector<SclNode>& tree = trees_.back();
    const std::string* outer_file = file_;
    const Path outer_folder = folder_;
    file_ = &name;
    folder_ = path.parent_path();
    for (const auto& node : tree) {
      if (quit_) break;
      if (auto done = outermost(node); !done.ok()) return done;
    }
    file_ = outer_file;
    folder_ = outer_folder;
    return Done{};
  }

  std::vector<SclGeometryPtr> results() const {
    if (outputs_.has_dump) return outputs_.dumped;
    if (outputs_.has_show) return outputs_.shown;
    if (last_solid_) return {last_solid_};
    return {};
  }

 private:
  Error refuse(const SclNode& node, const std::string& what) const {
    return bad_input(print_place(*file_, node.place) + ": " + what);
  }

  Result<Done> step(const SclNode& node) {
    if (++steps_ > limits_.steps)
      return refuse(node,
                    "expected at most " + std::to_string(limits_.steps) + " steps, found a procedure that goes on");
    if (limits_.stop && (steps_ & 255) == 0 && limits_.stop())
      return Error{print_place(*file_, node.place) + ": stopped before the procedure came to its end",
                   ErrorKind::stopped};
    return Done{};
  }

  Result<Done> count_values(const SclNode& node, std::size_t count) {
    values_ += count;
    if (values_ > limits_.values)
      return refuse(node, "expected at most " + std::to_string(limits_.values) + " members of arrays, found more");
    return Done{};
  }

  // ---- outermost statements -------------------------------------------------------------------------------------

  Result<Done> outermost(const SclNode& node) {
    switch (node.kind) {
      case Kind::nothing:
      case Kind::commented_out:
        return Done{};
      case Kind::block:
        for (const auto& child : node.children) {
          if (quit_) break;
          if (auto done = outermost(child); !done.ok()) return done;
        }
        return Done{};
      case Kind::quit:
        quit_ = true;
        return Done{};
      case Kind::set: {
        auto value = expression(node.children[0], global_);
        if (!value.ok()) return value.error();
        if (lower_case(node.text) == "demand_eval" && !value->as<bool>())
          return refuse(node, "expected true or false for demand_eval, found " + description_of(*value));
        return Done{};
      }
      case Kind::unset:
        return Done{};
      case Kind::procedure:
        return define(node);
      case Kind::include:
        return include(node);
      default:
        break;
    }
    auto flow = statement(node, global_);
    if (!flow.ok()) return flow.error();
    if (flow->returned) return refuse(node, "return stands outside of any procedure");
    return Done{};
  }

  Result<Done> define(const SclNode& node) {
    const std::string name = lower_case(node.text);
    if (is_scl_native(name))
      return refuse(node, "the procedure " + node.text + " has the name of a function of Alpha_1");
    if (procedures_.contains(name)) return refuse(node, "the procedure " + node.text + " is defined twice");
    std::set<std::string> formals;
    for (const auto& f : node.formals)
      if (!formals.insert(lower_case(f)).second)
        return refuse(node, "the formal argument " + f + " of " + node.text + " occurs twice");
    procedures_[name] = {&node, file_};
    return Done{};
  }

  Result<Done> include(const SclNode& node) {
    if (++include_depth_ > limits_.include_depth)
      return refuse(node, "expected includes at most " + std::to_string(limits_.include_depth) + " deep, found more");
    if (++includes_ > 1000) return refuse(node, "expected at most 1000 includes, found more");
    const Path path = folder_ / node.text;
    std::error_code code;
    if (!lies_within(path, root_) || !std::filesystem::is_regular_file(path, code))
      return refuse(node, "expected a file to include in the procedure's folder or below, found \"" + node.text + "\"");
    auto done = run_file(path, node.text);
    --include_depth_;
    return done;
  }

  // ---- statements with a value ----------------------------------------------------------------------------------

  using Executed = Result<Flow>;

  /// Counts how deep statements and expressions stand in each other, over all calls.
  struct Descent {
    explicit Descent(int& depth) : depth_(depth) { ++depth_; }
    ~Descent() { --depth_; }
    int& depth_;
  };

  Executed statement(const SclNode& node, Scope& scope) {
    const Descent descent(depth_);
    if (depth_ > max_depth) return refuse(node, "expected statements and calls less deep in each other");
    if (auto done = step(node); !done.ok()) return done.error();
    switch (node.kind) {
      case Kind::expression: {
        auto value = expression(node.children[0], scope);
        if (!value.ok()) return value.error();
        return Flow{std::move(*value), false};
      }
      case Kind::labelled:
        return labelled(node, scope);
      case Kind::sequence:
      case Kind::collected:
        return sequence(node, scope);
      case Kind::while_loop:
        return while_loop(node, scope);
      case Kind::choice: {
        auto condition = truth(node.children[0], scope, "if");
        if (!condition.ok()) return condition.error();
        return statement(node.children[*condition ? 1 : 2], scope);
      }
      case Kind::for_loop:
      case Kind::for_collected:
        return for_loop(node, scope);
      case Kind::returned: {
        if (calls_ == 0) return refuse(node, "return stands outside of any procedure");
        auto value = expression(node.children[0], scope);
        if (!value.ok()) return value.error();
        return Flow{std::move(*value), true};
      }
      case Kind::commented_out:
        return Flow{};
      default:
        return refuse(node, "this statement has no value");
    }
  }

  Executed labelled(const SclNode& node, Scope& scope) {
    const std::string key = lower_case(node.text);
    if (scl_predefined(key)) return refuse(node, "the label " + node.text + " is already defined by Alpha_1");
    if (const auto found = scope.labels.find(key); found != scope.labels.end()) {
      if (found->second.first != node.text)
        return refuse(node, "the labels " + found->second.first + " and " + node.text +
                                " differ by case only, which Alpha_1 may not tell apart");
      return refuse(node, "the label " + node.text + " is defined twice");
    }
    auto flow = statement(node.children[0], scope);
    if (!flow.ok() || flow->returned) return flow;
    if (flow->value.as<std::monostate>())
      return refuse(node, "the label " + node.text + " stands on a statement without a value");
    scope.labels[key] = {node.text, flow->value};
    if (const auto* g = flow->value.as<SclGeometryPtr>(); g && &scope == &global_)
      if (is_solid(**g) || kind_of(**g) == SclGeometryKind::surface || kind_of(**g) == SclGeometryKind::group ||
          kind_of(**g) == SclGeometryKind::shell)
        last_solid_ = *g;
    return flow;
  }

  Executed sequence(const SclNode& node, Scope& outer) {
    Scope scope{&outer, {}};
    auto collected = std::make_shared<std::vector<SclValue>>();
    Flow last;
    for (const auto& child : node.children) {
      auto flow = statement(child, scope);
      if (!flow.ok() || flow->returned) return flow;
      last = std::move(*flow);
      if (node.kind != Kind::collected || child.kind == Kind::commented_out) continue;
      if (last.value.as<std::monostate>()) return refuse(child, "a statement without a value cannot be collected");
      collected->push_back(last.value);
    }
    if (node.kind == Kind::sequence) return last;
    if (auto done = count_values(node, collected->size()); !done.ok()) return done.error();
    return Flow{SclValue(SclArray(collected)), false};
  }

  Executed while_loop(const SclNode& node, Scope& outer) {
    Flow last;
    for (;;) {
      auto condition = truth(node.children[0], outer, "while");
      if (!condition.ok()) return condition.error();
      if (!*condition) return last;
      Scope scope{&outer, {}};
      auto flow = statement(node.children[1], scope);
      if (!flow.ok() || flow->returned) return flow;
      last = std::move(*flow);
    }
  }

  Executed for_loop(const SclNode& node, Scope& outer) {
    const std::string index = lower_case(node.text);
    auto value = expression(node.children[0], outer);
    if (!value.ok()) return value.error();
    auto collected = std::make_shared<std::vector<SclValue>>();
    Flow last;
    for (;;) {
      Scope scope{&outer, {}};
      scope.labels[index] = {node.text, *value};
      auto condition = truth(node.children[1], scope, "for");
      if (!condition.ok()) return condition.error();
      if (!*condition) break;
      auto flow = statement(node.children[3], scope);
      if (!flow.ok() || flow->returned) return flow;
      last = std::move(*flow);
      if (node.kind == Kind::for_collected) {
        if (last.value.as<std::monostate>())
          return refuse(node.children[3], "a statement without a value cannot be collected");
        if (auto done = count_values(node, 1); !done.ok()) return done.error();
        collected->push_back(last.value);
      }
      value = expression(node.children[2], scope);
      if (!value.ok()) return value.error();
    }
    if (node.kind == Kind::for_loop) return last;
    return Flow{SclValue(SclArray(collected)), false};
  }

  // ---- expressions ----------------------------------------------------------------------------------------------

  using Valued = Result<SclValue>;

  Result<bool> truth(const SclNode& node, Scope& scope, const char* of) {
    if (auto done = step(node); !done.ok()) return done.error();
    auto value = expression(node, scope);
    if (!value.ok()) return value.error();
    const auto* b = value->as<bool>();
    if (!b)
      return refuse(
          node, std::string("expected true or false as the condition of ") + of + ", found " + description_of(*value));
    return *b;
  }

  Valued expression(const SclNode& node, Scope& scope) {
    const Descent descent(depth_);
    if (depth_ > max_depth) return refuse(node, "expected statements and calls less deep in each other");
    switch (node.kind) {
      case Kind::integer:
        return SclValue(node.integer);
      case Kind::real:
        return SclValue(node.real);
      case Kind::string:
        return SclValue(node.text);
      case Kind::boolean:
        return SclValue(node.truth);
      case Kind::label:
        return label(node, scope);
      case Kind::call:
        return call(node, scope);
      case Kind::negate: {
        auto v = expression(node.children[0], scope);
        if (!v.ok()) return v;
        if (const auto* n = v->as<std::int64_t>()) {
          if (*n == INT64_MIN) return refuse(node, "a whole number is too large");
          return SclValue(-*n);
        }
        if (const auto* n = v->as<double>()) return SclValue(-*n);
        return refuse(node, "expected a number after '-', found " + description_of(*v));
      }
      case Kind::negation: {
        auto v = expression(node.children[0], scope);
        if (!v.ok()) return v;
        if (const auto* b = v->as<bool>()) return SclValue(!*b);
        return refuse(node, "expected true or false after '!', found " + description_of(*v));
      }
      case Kind::binary:
        return binary(node, scope);
      default:
        return refuse(node, "expected an expression");
    }
  }

  Valued label(const SclNode& node, Scope& scope) {
    const std::string key = lower_case(node.text);
    for (Scope* s = &scope; s; s = s->parent) {
      const auto found = s->labels.find(key);
      if (found == s->labels.end()) continue;
      if (found->second.first != node.text)
        return refuse(
            node, "unknown label " + node.text + " (there is " + found->second.first + ", and Alpha_1 may heed case)");
      return found->second.second;
    }
    if (auto predefined = scl_predefined(key)) return *predefined;
    return refuse(node, "unknown label " + node.text);
  }

  Valued call(const SclNode& node, Scope& scope) {
    if (auto done = step(node); !done.ok()) return done.error();
    const std::string name = lower_case(node.text);
    const auto procedure = procedures_.find(name);
    if (procedure == procedures_.end() && !is_scl_native(name)) {
      const std::string why = why_not_native(name);
      return refuse(node, "unknown function " + node.text + (why.empty() ? "" : ": " + why));
    }
    std::vector<SclValue> arguments;
    for (const auto& child : node.children) {
      auto value = expression(child, scope);
      if (!value.ok()) return value;
      if (value->as<std::monostate>()) return refuse(child, "expected an argument with a value, found nothing");
      arguments.push_back(std::move(*value));
    }
    if (procedure != procedures_.end()) return call_procedure(node, procedure->second, std::move(arguments));
    if (limits_.stop && limits_.stop())
      return Error{print_place(*file_, node.place) + ": stopped before the procedure came to its end",
                   ErrorKind::stopped};
    SclCallContext context{outputs_, limits_.stop};
    auto result = call_scl_native(name, arguments, context);
    if (!result.ok())
      return Error{print_place(*file_, node.place) + ": " + node.text + ": " + result.error().message,
                   result.error().kind};
    if (result->as<SclGeometryPtr>() && ++objects_ > limits_.objects)
      return refuse(node, "expected at most " + std::to_string(limits_.objects) + " objects, found more");
    if (result->as<SclArray>())
      if (auto done = count_values(node, (*result->as<SclArray>())->size()); !done.ok()) return done.error();
    return result;
  }

  Valued call_procedure(const SclNode& node, const Procedure& procedure, std::vector<SclValue> arguments) {
    const auto& formals = procedure.node->formals;
    if (formals.size() != arguments.size())
      return refuse(node, node.text + ": expected " + std::to_string(formals.size()) + " arguments, found " +
                              std::to_string(arguments.size()));
    if (calls_ >= limits_.recursion)
      return refuse(node,
                    node.text + ": expected calls at most " + std::to_string(limits_.recursion) + " deep, found more");
    Scope scope{&global_, {}};
    for (std::size_t i = 0; i < formals.size(); ++i)
      scope.labels[lower_case(formals[i])] = {formals[i], std::move(arguments[i])};
    const std::string* outer = file_;
    file_ = procedure.file;
    ++calls_;
    auto flow = statement(procedure.node->children[0], scope);
    --calls_;
    if (!flow.ok()) return flow.error();
    file_ = outer;
    return std::move(flow->value);
  }

  Valued binary(const SclNode& node, Scope& scope) {
    const std::string& op = node.text;
    auto left = expression(node.children[0], scope);
    if (!left.ok()) return left;
    if (op == "&&" || op == "||") {
      const auto* a = left->as<bool>();
      if (!a) return refuse(node, "expected true or false before '" + op + "', found " + description_of(*left));
      if (*a == (op == "||")) return SclValue(*a);
      auto right = expression(node.children[1], scope);
      if (!right.ok()) return right;
      if (!right->as<bool>())
        return refuse(node, "expected true or false after '" + op + "', found " + description_of(*right));
      return right;
    }
    auto right = expression(node.children[1], scope);
    if (!right.ok()) return right;
    double x = 0, y = 0;
    if (!number_of(*left, x) || !number_of(*right, y)) {
      if (op == "==" || op == "!=") {
        const bool same_kind = left->value.index() == right->value.index();
        if (same_kind && left->as<std::string>())
          return SclValue((*left->as<std::string>() == *right->as<std::string>()) == (op == "=="));
        if (same_kind && left->as<bool>()) return SclValue((*left->as<bool>() == *right->as<bool>()) == (op == "=="));
      }
      return refuse(node, "expected numbers around '" + op + "', found " + description_of(*left) + " and " +
                              description_of(*right));
    }
    if (op == "<") return SclValue(x < y);
    if (op == "<=") return SclValue(x <= y);
    if (op == ">") return SclValue(x > y);
    if (op == ">=") return SclValue(x >= y);
    if (op == "==") return SclValue(x == y);
    if (op == "!=") return SclValue(x != y);
    const auto *a = left->as<std::int64_t>(), *b = right->as<std::int64_t>();
    if (a && b && op != "**") {
      std::int64_t result = 0;
      bool overflow = false;
      if (op == "+")
        overflow = __builtin_add_overflow(*a, *b, &result);
      else if (op == "-")
        overflow = __builtin_sub_overflow(*a, *b, &result);
      else if (op == "*")
        overflow = __builtin_mul_overflow(*a, *b, &result);
      else
        return refuse(
            node,
            "expected a real number around '/', found two whole numbers (how Alpha_1 divides them is not documented)");
      if (overflow) return refuse(node, "a whole number is too large");
      return SclValue(result);
    }
    if (op == "/" && y == 0) return refuse(node, "division by 0");
    const double result = op == "+"   ? x + y
                          : op == "-" ? x - y
                          : op == "*" ? x * y
                          : op == "/" ? x / y
                                      : std::pow(x, y);
    if (!std::isfinite(result)) return refuse(node, "the result of '" + op + "' is not a finite number");
    return SclValue(result);
  }

  const SclLimits& limits_;
  const Path root_;                         // the outermost file's folder
  std::deque<std::string> names_;           // of files; addresses stay
  std::deque<std::vector<SclNode>> trees_;  // procedures point into them
  const std::string* file_ = nullptr;
  Path folder_;
  Scope global_;
  std::map<std::string, Procedure> procedures_;
  SclOutputs outputs_;
  SclGeometryPtr last_solid_;
  std::size_t steps_ = 0, values_ = 0, objects_ = 0, includes_ = 0;
  int calls_ = 0, include_depth_ = 0, depth_ = 0;
  bool quit_ = false;
};

}  // namespace

Result<SclOutcome> run_scl(const Path& path, const SclLimits& limits) {
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code))
    return bad_input(path.string() + ": expected an Alpha_1 procedure, found no such file");
  if (auto readable = read_file(path, limits.bytes); !readable.ok()) return readable.error();
  Interpreter interpreter(limits, path.parent_path());
  SclOutcome outcome;
  auto done = interpreter.run_file(path, path.filename().string());
  if (!done.ok()) {
    if (done.error().kind == ErrorKind::stopped) return done.error();
    outcome.complaints.push_back(done.error().message);
    return outcome;
  }
  outcome.objects = interpreter.results();
  if (outcome.objects.empty())
    outcome.complaints.push_back(path.filename().string() + ": expected a procedure that makes an object, found none");
  return outcome;
}

}  // namespace partscribe::verify
