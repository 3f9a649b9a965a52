/// The stand-ins of the 1993 paper's images, made once for all tests of a program.
#pragma once

#include "cli/paper/paper_figure.h"

namespace partscribe::testing {

inline const cli::PaperSubjects& subjects_of_paper() {
  static const cli::PaperSubjects subjects = [] {
    core::Context context;
    return *cli::paper_subjects(context);
  }();
  return subjects;
}

}  // namespace partscribe::testing
