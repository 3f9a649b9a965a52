{{#center}}translate([{{center}}]) {{/center}}disc({{radius}});{{#role}}  // {{role}}{{/role}}
