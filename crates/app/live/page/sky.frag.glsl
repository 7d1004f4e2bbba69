in vec3 vRay;
uniform vec3 uTop;
out vec4 color;
void main() {
    float up = normalize(vRay).z;
    color = vec4(screen(mix(uHaze, uTop, smoothstep(0.0, 0.42, up))), 1.0);
}
