{{#header}}
//{{line}}
{{/header}}

{{#library}}
use <partscribe.scad>

{{/library}}
{{#switches}}
/* [Switches] */
{{#as_designed}}
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
{{/as_designed}}
{{#as_scanned}}
// true: where the scan has the part, false: in the part's own frame
as_scanned = {{as_scanned}};
{{/as_scanned}}

{{/switches}}
{{#groups}}
/* [{{title}}] */
{{#parameters}}
{{#meaning}}
// {{meaning}}
{{/meaning}}
{{statement}}{{#fit}}  // {{fit}}{{/fit}}
{{/parameters}}

{{/groups}}
{{#curved}}
/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = {{chord_error}};

{{/curved}}
{{#guarded}}
{{#asserts}}
assert({{condition}}, "{{message}}");
{{/asserts}}

{{/guarded}}
{{#objects}}
{{#remarks}}
// {{line}}
{{/remarks}}
{{body}}

{{/objects}}
{{#placement}}
// From the part's own frame to the scan's.
module scan_from_part() {{placement}}children();

{{/placement}}
{{helpers}}
{{#last}}
module part() {{last}}();

{{/last}}
{{#placement}}
if (as_scanned) scan_from_part() part();
else part();
{{/placement}}
{{^placement}}
part();
{{/placement}}
{{#data}}

// {{remark}}
{{#call}}
{{name}} = {{call}};
{{/call}}
{{^call}}
{{name}} = [
  {{rows}}
];
{{/call}}
{{/data}}
