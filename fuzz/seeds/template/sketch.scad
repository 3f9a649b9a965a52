{{tables}}
{{#single}}
module {{name}}()
  {{loop}}
{{/single}}
{{#several}}
module {{name}}() difference() {
  {{outer}}
  {{holes}}
}
{{/several}}
