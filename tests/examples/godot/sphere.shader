shader_type spatial;
render_mode ambient_light_disabled;

// sbrdf_eval

varying vec3 tangent;
varying vec3 binormal;

void vertex() {
  tangent = (MODELVIEW_MATRIX * vec4(TANGENT, 0.0)).xyz;
  binormal = (MODELVIEW_MATRIX * vec4(BINORMAL, 0.0)).xyz;
}

void fragment() {
  ALBEDO = vec3(1.0);
}

// The frame of the surface, in which directions are: x the tangent, z the normal.
void light() {
  vec3 z = normalize(NORMAL);
  vec3 x = normalize(tangent - z * dot(z, tangent));
  vec3 y = cross(z, x) * sign(dot(cross(z, x), binormal));
  vec3 w_i = vec3(dot(LIGHT, x), dot(LIGHT, y), dot(LIGHT, z));
  vec3 w_v = vec3(dot(VIEW, x), dot(VIEW, y), dot(VIEW, z));
  DIFFUSE_LIGHT += sbrdf_eval(w_i, w_v) * max(w_i.z, 0.0) * LIGHT_COLOR * ATTENUATION;
}
