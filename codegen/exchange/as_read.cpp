#include "codegen/exchange/as_read.h"

#include <IFSelect_ReturnStatus.hxx>
#include <IGESControl_Controller.hxx>
#include <IGESControl_Reader.hxx>
#include <IGESControl_Writer.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <STEPControl_Controller.hxx>
#include <STEPControl_Reader.hxx>
#include <STEPControl_Writer.hxx>
#include <TopoDS_Shape.hxx>

#include "core/files.h"

namespace partscribe::codegen {
namespace {

template <class Reader>
std::optional<TopoDS_Shape> read(const Path& path) {
  Reader reader;
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone || reader.TransferRoots() < 1) return std::nullopt;
  return reader.OneShape();
}

std::optional<TopoDS_Shape> through_step(const TopoDS_Shape& body, const Path& path) {
  STEPControl_Controller::Init();
  Interface_Static::SetCVal("write.step.unit", "MM");
  STEPControl_Writer writer;
  if (writer.Transfer(body, STEPControl_AsIs) != IFSelect_RetDone || writer.Write(path.c_str()) != IFSelect_RetDone)
    return std::nullopt;
  return read<STEPControl_Reader>(path);
}

std::optional<TopoDS_Shape> through_iges(const TopoDS_Shape& body, const Path& path) {
  constexpr int as_solid = 1;
  IGESControl_Controller::Init();
  IGESControl_Writer writer("MM", as_solid);
  if (!writer.AddShape(body) || !writer.Write(path.c_str())) return std::nullopt;
  return read<IGESControl_Reader>(path);
}

}  // namespace

std::optional<std::vector<TopoDS_Shape>> as_read(const TopoDS_Shape& body) {
  Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer));
  Interface_Static::SetCVal("xstep.cascade.unit", "MM");
  const auto folder = TemporaryDirectory::make();
  if (!folder) return std::nullopt;
  std::vector<TopoDS_Shape> shapes;
  for (auto shape : {through_step(body, folder->path() / "body.step"), through_iges(body, folder->path() / "body.igs")})
    if (shape)
      shapes.push_back(*shape);
    else
      return std::nullopt;
  return shapes;
}

}  // namespace partscribe::codegen
