in vec3 vPos;
in vec2 vThread;
uniform vec3 uThread;
out vec4 color;
void main() {
    vec2 t = vThread / 0.09;
    vec2 px = fwidth(t) + 1e-4;
    vec2 d = abs(fract(t) - 0.5);
    vec2 line = clamp((0.045 - (0.5 - d)) / px + 0.5, 0.0, 1.0) * min(vec2(1.0), 0.09 / px + 0.25);
    float cover = max(line.x, line.y);
    if (cover < 0.02) discard;
    color = vec4(screen(hazed(uThread * (uSkyColor + 0.6 * uSunColor), vPos)), cover * 0.8);
}
