#include "codegen/exchange/iges.h"

#include <IGESBasic_Name.hxx>
#include <IGESControl_Controller.hxx>
#include <IGESControl_Writer.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESEntity.hxx>
#include <IGESData_IGESModel.hxx>
#include <IGESGraph_Color.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <Standard_Failure.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopoDS_Shape.hxx>
#include <TransferBRep.hxx>
#include <TransferBRep_ShapeMapper.hxx>
#include <Transfer_FinderProcess.hxx>
#include <map>
#include <sstream>

#include "codegen/describe.h"
#include "codegen/exchange/brep.h"
#include "codegen/exchange/iges_tree.h"
#include "core/number.h"

namespace partscribe::codegen {
namespace {

using Entity = Handle(IGESData_IGESEntity);

Handle(TCollection_HAsciiString) text(const std::string& s) { return new TCollection_HAsciiString(s.c_str()); }

/// The entity that a shape became; null if the writer merged it away.
Entity entity_of(IGESControl_Writer& writer, const TopoDS_Shape& shape) {
  const Handle(TransferBRep_ShapeMapper) mapper = TransferBRep::ShapeMapper(writer.TransferProcess(), shape);
  Handle(Standard_Transient) found;
  writer.TransferProcess()->FindTypedTransient(mapper, STANDARD_TYPE(IGESData_IGESEntity), found);
  return Entity::DownCast(found);
}

/// Hangs names and colours on entities, in the order of the calls (OpenCASCADE's own writer uses the order of
/// addresses).
class Labeller {
 public:
  explicit Labeller(IGESControl_Writer& writer) : writer_(writer) {}

  void name(const Entity& entity, const std::string& words) {
    const Handle(IGESBasic_Name) name = new IGESBasic_Name;
    name->Init(1, text(one_line(words)));
    entity->AddProperty(name);
    writer_.AddEntity(name);
  }

  void color(const Entity& entity, const std::array<double, 3>& rgb) {
    Handle(IGESGraph_Color)& color = colors_[rgb];
    if (color.IsNull()) {
      color = new IGESGraph_Color;
      color->Init(snapped(100 * rgb[0], 0.01), snapped(100 * rgb[1], 0.01), snapped(100 * rgb[2], 0.01), {});
      writer_.AddEntity(color);
    }
    entity->InitColor(color);
  }

 private:
  IGESControl_Writer& writer_;
  std::map<std::array<double, 3>, Handle(IGESGraph_Color)> colors_;
};

/// Everything in the header that would differ between two runs or two machines.
void set_header(IGESControl_Writer& writer, const Model& model, const std::string& file) {
  const Handle(IGESData_IGESModel) iges = writer.Model();
  IGESData_GlobalSection global = iges->GlobalSection();
  const std::string program = one_line(model.provenance.program + " " + model.provenance.version);
  global.SetSendName(text(one_line(model.name)));
  global.SetReceiveName(text(one_line(model.name)));
  global.SetFileName(text(file));
  global.SetSystemId(text(program));
  global.SetInterfaceVersion(text(program));
  global.SetAuthorName(text(one_line(model.provenance.program)));
  global.SetCompanyName(text(""));
  global.SetDate(text("19700101.000000"));
  global.SetLastChangeDate(text("19700101.000000"));
  global.SetIGESVersion(11);
  iges->SetGlobalSection(global);
  iges->ClearStartSection();
  for (const auto& line : header_lines(model)) {
    for (std::size_t at = 0; at < std::max<std::size_t>(line.size(), 1); at += 72) {
      iges->AddStartLine(line.substr(std::min(at, line.size()), 72).c_str());
    }
  }
}

}  // namespace

Result<Artifact> emit_iges(const CheckedModel& checked, const EmitOptions& options, Context& context) {
  const Model& model = *checked;
  const auto brep = brep_of(checked, options, context);
  if (!brep.ok()) return brep.error();
  try {
    Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer));
    IGESControl_Controller::Init();
    // Solids keep their shared edges as manifold solids; loose faces are better understood trimmed.
    IGESControl_Writer writer("MM", brep->solid ? 1 : 0);
    if (!writer.AddShape(*brep->shape))
      return bad_input("model '" + model.name + "': OpenCASCADE could not turn the body into IGES");
    writer.ComputeModel();

    Labeller labeller(writer);
    if (const Entity body = entity_of(writer, *brep->shape); !body.IsNull()) labeller.name(body, model.name);
    for (const WrittenFace& face : brep->faces) {
      const Entity entity = entity_of(writer, *face.face);
      if (entity.IsNull()) continue;
      if (!entity->HasName()) labeller.name(entity, face.name);
      labeller.color(entity, face.color);
    }
    const std::vector<IgesTreeNode> tree = brep->solid ? iges_tree(model) : std::vector<IgesTreeNode>{};
    if (!tree.empty()) {
      writer.AddEntity(Entity(tree.back().entity.get()));
      for (const IgesTreeNode& node : tree) labeller.name(Entity(node.entity.get()), node.name);
    }
    set_header(writer, model, options.stem + ".igs");

    std::ostringstream stream;
    stream.imbue(std::locale::classic());
    if (!writer.Write(stream)) return bad_input("model '" + model.name + "': OpenCASCADE could not write IGES");
    return Artifact{"iges", {{options.stem + ".igs", stream.str()}}};
  } catch (const Standard_Failure& failure) {
    return bad_input("model '" + model.name + "': IGES writer of OpenCASCADE says: " + failure.GetMessageString());
  }
}

Backend iges_backend() {
  return {"iges", ".igs", {}, "IGES 5.3: exact solid and, where possible, its CSG tree", {}, emit_iges};
}

}  // namespace partscribe::codegen
