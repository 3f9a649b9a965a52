polygon({{open}}[
  {{rows}}
]{{close}});{{#role}}  // {{role}}{{/role}}
