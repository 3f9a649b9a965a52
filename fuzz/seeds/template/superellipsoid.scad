module {{name}}()
  {{place}}superellipsoid([{{a1}}, {{a2}}, {{a3}}], e1 = {{e1}}, e2 = {{e2}}, taper = [{{taper_x}}, {{taper_y}}],
    {{#bend}}bend = {{bend}}, {{/bend}}chord_error = chord_error);
