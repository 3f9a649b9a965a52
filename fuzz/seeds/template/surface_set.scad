{{#sheet}}
// An open sheet; what OpenSCAD builds is a solid that reaches this thickness behind it.
module {{name}}()
  {{place}}surface_sheet({{surfaces}}, {{corners}}, {{name}}_faces, {{name}}_rim, thickness = {{thickness}}{{towards}});
{{/sheet}}
{{^sheet}}
module {{name}}()
  {{place}}surface_body({{surfaces}}, {{corners}}, {{name}}_faces);
{{/sheet}}
