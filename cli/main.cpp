/// The program: the list of its commands.
#include "cli/commands.h"
#include "verify/evaluate/run_occt.h"

int main(int argc, char** argv) {
  using namespace partscribe::cli;
  if (const auto code = serve_as_reader(argc, argv)) return *code;  // STEP and IGES are read in a process of their own
  const std::vector<Command> commands = {
      build_command(),    scan_command(),   fit_command(),     emit_command(),    verify_command(),
      report_command(),   render_command(), explain_command(), measure_command(), analyse_command(),
      simulate_command(), views_command(),  paper_command(),   mcp_command(),
  };
  return run_program(argc, argv, commands, PARTSCRIBE_VERSION);
}
