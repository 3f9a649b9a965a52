#include "codegen/exchange/step.h"

#include <APIHeaderSection_MakeHeader.hxx>
#include <IFSelect_ReturnStatus.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Controller.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <Standard_Failure.hxx>
#include <TCollection_ExtendedString.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopoDS_Shape.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_WorkSession.hxx>

#include "codegen/describe.h"
#include "codegen/exchange/brep.h"

namespace partscribe::codegen {
namespace {

Handle(TCollection_HAsciiString) step_text(const std::string& s) { return new TCollection_HAsciiString(s.c_str()); }

/// Names and colours hang on the labels of a document; STEP's writer walks it.
Handle(TDocStd_Document) document_of(const Model& model, const Brep& brep) {
  Handle(TDocStd_Document) document;
  XCAFApp_Application::GetApplication()->NewDocument("MDTV-XCAF", document);
  const Handle(XCAFDoc_ShapeTool) shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
  const Handle(XCAFDoc_ColorTool) colors = XCAFDoc_DocumentTool::ColorTool(document->Main());
  const TDF_Label label = shapes->AddShape(*brep.shape, false);
  TDataStd_Name::Set(label, TCollection_ExtendedString(one_line(model.name).c_str(), true));
  for (const WrittenFace& face : brep.faces) {
    const TDF_Label sub = shapes->AddSubShape(label, *face.face);
    if (sub.IsNull()) continue;
    TDataStd_Name::Set(sub, TCollection_ExtendedString(one_line(face.name).c_str(), true));
    colors->SetColor(sub, Quantity_Color(face.color[0], face.color[1], face.color[2], Quantity_TOC_sRGB),
                     XCAFDoc_ColorSurf);
  }
  return document;
}

}  // namespace

Result<Artifact> emit_step(const CheckedModel& checked, const EmitOptions& options, Context& context) {
  const Model& model = *checked;
  const auto brep = brep_of(checked, options, context);
  if (!brep.ok()) return brep.error();
  try {
    Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer));
    STEPCAFControl_Controller::Init();
    Interface_Static::SetCVal("write.step.schema", "AP214IS");
    Interface_Static::SetCVal("write.step.unit", "MM");
    Interface_Static::SetCVal("write.step.product.name", one_line(model.name).c_str());
    Interface_Static::SetIVal("write.stepcaf.subshapes.name", 1);

    const Handle(TDocStd_Document) document = document_of(model, *brep);
    STEPCAFControl_Writer writer;
    const bool transferred = writer.Transfer(document, STEPControl_AsIs);
    XCAFApp_Application::GetApplication()->Close(document);
    if (!transferred) return bad_input("model '" + model.name + "': OpenCASCADE could not turn the body into STEP");

    // Everything that would differ between two runs or two machines.
    APIHeaderSection_MakeHeader header(writer.ChangeWriter().Model());
    header.SetName(step_text(options.stem + ".step"));
    header.SetTimeStamp(step_text("1970-01-01T00:00:00"));
    header.SetAuthorValue(1, step_text(""));
    header.SetOrganizationValue(1, step_text(""));
    header.SetOriginatingSystem(step_text(one_line(model.provenance.program + " " + model.provenance.version)));
    header.SetPreprocessorVersion(step_text("Open CASCADE"));
    header.SetAuthorisation(step_text(""));

    const auto folder = TemporaryDirectory::make();
    if (!folder) return folder.error();
    const Path path = folder->path() / (options.stem + ".step");
    if (writer.Write(path.string().c_str()) != IFSelect_RetDone)
      return Error{path.string() + ": could not be written", ErrorKind::stopped};
    auto bytes = read_file(path);
    if (!bytes.ok()) return bytes.error();
    return Artifact{"step", {{options.stem + ".step", std::move(bytes).value()}}};
  } catch (const Standard_Failure& failure) {
    return bad_input("model '" + model.name + "': STEP writer of OpenCASCADE says: " + failure.GetMessageString());
  }
}

Backend step_backend() {
  return {"step", ".step", {}, "STEP AP214: exact solid with names and colours", {}, emit_step};
}

}  // namespace partscribe::codegen
