// Loops of corners [x, y] and arcs [center, radius, from, to] at z = 0; the walls lean inwards by the draft.
module {{name}}()
{{^place}}
  drafted([
    {{loops}}
  ], height = {{height}}, {{#below}}below = {{below}}, {{/below}}draft = {{draft}}, chord_error = chord_error);
{{/place}}
{{#place}}
  {{place}}drafted([
      {{loops}}
    ], height = {{height}}, {{#below}}below = {{below}}, {{/below}}draft = {{draft}}, chord_error = chord_error);
{{/place}}
