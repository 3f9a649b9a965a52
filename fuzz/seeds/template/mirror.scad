module {{name}}() {{place}}{
{{#keep}}
  {{operand}}();
{{/keep}}
  {{behind}}mirror({{normal}}) {{operand}}();
}
