{{^place}}
module {{name}}() {{operation}}() {
{{#operands}}
  {{line}}();
{{/operands}}
}
{{/place}}
{{#place}}
module {{name}}()
  {{place}}{{operation}}() {
    {{#operands}}
    {{line}}();
    {{/operands}}
  }
{{/place}}
