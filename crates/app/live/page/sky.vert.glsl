layout(location = 0) in vec2 aPlace;
uniform mat3 uView;   // right, up, back
uniform vec2 uField;  // half extents of the picture at distance 1
out vec3 vRay;
void main() {
    vRay = uView * vec3(aPlace * uField, -1.0);
    gl_Position = vec4(aPlace, 0.99999, 1.0);
}
