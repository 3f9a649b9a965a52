/// The files of one run in their folder: nobody's are overwritten unasked, and what a run that did not end leaves is no
/// result.
#pragma once

#include <string>
#include <vector>

#include "cli/session.h"
#include "core/files.h"
#include "core/result.h"

namespace partscribe::cli {

/// From the first file of a run to its last a file `unfinished.json` says whose the others are. The next run of the
/// same command on the same inputs replaces them, but none that was changed since.
class ResultFolder {
 public:
  /// `files`: all that the run may write, by name. `inputs`: what it reads.
  ResultFolder(Path folder, std::vector<std::string> files, std::string command, const std::vector<Path>& inputs);

  const Path& path() const { return folder_; }

  /// A usage error if one of the files exists, --force was not given, and it is not what an unfinished run left; asked
  /// before the work.
  Result<Done> check(bool force) const;
  /// Removes what is to be replaced, an old verdict and report included. From now on files may be written.
  Result<Done> begin();
  /// Tells whose the files are that were written so far: for a run that is killed.
  Result<Done> mark() const;
  /// "; what is in DIR (part.step) is unfinished ...": the end of the line that says why. Empty if nothing was written
  /// yet.
  std::string left() const;
  /// All files are there; or, if `outcome` is an error, it also says which of them are and what may be done with them.
  /// A folder that was made for nothing is removed.
  Result<int> close(Result<int> outcome) const;

 private:
  std::vector<std::string> present() const;

  Path folder_;
  std::vector<std::string> files_, inputs_;
  std::string command_;
  bool begun_ = false, was_there_ = false;
};

}  // namespace partscribe::cli
