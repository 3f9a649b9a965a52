/// The architecture in names: each folder is a namespace and sees, besides its own names, those of the folders below
/// it.
#pragma once

namespace partscribe::core {}

namespace partscribe::geometry {
using namespace core;
}

namespace partscribe::model {
using namespace core;
using namespace geometry;
}  // namespace partscribe::model

namespace partscribe::scan {
using namespace core;
using namespace geometry;
using namespace model;
}  // namespace partscribe::scan

namespace partscribe::fit {
using namespace core;
using namespace geometry;
using namespace model;
}  // namespace partscribe::fit

namespace partscribe::codegen {
using namespace core;
using namespace geometry;
using namespace model;
}  // namespace partscribe::codegen

namespace partscribe::verify {
using namespace core;
using namespace geometry;
using namespace model;
}  // namespace partscribe::verify

namespace partscribe::cli {
using namespace core;
using namespace geometry;
using namespace model;
using namespace scan;
using namespace fit;
using namespace codegen;
using namespace verify;
}  // namespace partscribe::cli
