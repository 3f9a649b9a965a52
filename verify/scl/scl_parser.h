/// Turns the text of an Alpha_1 procedure into a tree, by the grammar of the SCL manual and nothing beyond it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "verify/scl/scl_lexer.h"

namespace partscribe::verify {

/// One statement or expression.
struct SclNode {
  enum class Kind {
    // expressions
    integer,
    real,
    string,
    boolean,
    label,
    call,
    negate,
    negation,
    binary,
    // statements
    expression,     ///< children: expression
    labelled,       ///< text: label; children: statement
    sequence,       ///< `{ }` or seq: children statements; the last value counts
    collected,      ///< seqCollect: the array of all values
    while_loop,     ///< condition, body
    choice,         ///< condition, then, else
    for_loop,       ///< text: index; first value, condition, next value, body
    for_collected,  ///< the same, giving the array of all values
    returned,       ///< expression
    commented_out,  ///< parsed and not executed
    set,
    unset,  ///< text: name
    quit,
    block,      ///< << >>: statements
    procedure,  ///< text: name; formals; body
    include,    ///< text: file
    nothing,    ///< a lone end of statement
  };
  Kind kind = Kind::nothing;
  SclPlace place;
  std::string text;  ///< name, operator or string
  std::int64_t integer = 0;
  double real = 0;
  bool truth = false;
  std::vector<std::string> formals;
  std::vector<SclNode> children;
};

/// All forms of one file in order. The error names the first thing the grammar does not allow, with file, line
/// and column; constructs whose meaning the manual does not tell (++, --, ::, const) are refused as well.
Result<std::vector<SclNode>> parse_scl(std::string_view text, const std::string& file);

}  // namespace partscribe::verify
