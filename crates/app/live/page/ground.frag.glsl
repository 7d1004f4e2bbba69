in vec3 vPos;
uniform vec3 uGrass;
uniform vec3 uLine;
uniform vec3 uGoal;       // x, y, heading
uniform float uHalfMouth;
uniform vec4 uRobot;      // x, y, heading, how much of the reach is shown
uniform vec4 uReach;      // near, far, right, left
uniform sampler2D uHeat;
uniform vec2 uCells;      // columns, rows
uniform float uHeatShare;
out vec4 color;

float hash(vec2 p) {
    return fract(sin(dot(p, vec2(41.3, 289.1))) * 43758.5453);
}

float noise(vec2 p) {
    vec2 i = floor(p), f = fract(p);
    f = f * f * (3.0 - 2.0 * f);
    return mix(mix(hash(i), hash(i + vec2(1, 0)), f.x), mix(hash(i + vec2(0, 1)), hash(i + vec2(1, 1)), f.x), f.y);
}

// How much of a pixel a line covers at distance d from its middle.
float stroke(float d, float halfWidth, float px) {
    float cover = clamp((halfWidth - abs(d)) / px + 0.5, 0.0, 1.0);
    return cover * min(1.0, 2.0 * halfWidth / px);
}

float box(vec2 p, vec2 low, vec2 high) {
    vec2 d = max(low - p, p - high);
    return max(d.x, d.y);
}

vec2 inAxes(vec2 p, vec3 pose) {
    float c = cos(pose.z), s = sin(pose.z);
    vec2 d = p - pose.xy;
    return vec2(c * d.x + s * d.y, c * d.y - s * d.x);
}

void main() {
    vec2 p = vPos.xy;
    float px = length(fwidth(p)) * 0.6 + 1e-4;
    // Mown in stripes of a meter, with some unevenness that fades with the distance.
    float stripe = smoothstep(-px, px, abs(fract(p.x / 2.0 + 0.25) - 0.5) * 2.0 - 0.5);
    float fine = clamp(0.012 / px, 0.0, 1.0);
    float grain = mix(0.5, noise(p * 42.0), fine) * 0.5 + noise(p * 1.7) * 0.5;
    vec3 c = uGrass * (0.74 + 0.22 * stripe + 0.24 * grain);

    // Lines: the middle with its circle, and what belongs to the goal.
    float w = 0.03;
    float lines = stroke(length(p) - 1.8, w, px);
    lines = max(lines, clamp((0.07 - length(p)) / px + 0.5, 0.0, 1.0));
    lines = max(lines, stroke(p.x, w, px) * step(abs(p.y), 5.0));
    vec2 g = inAxes(p, uGoal);
    lines = max(lines, stroke(g.x, w, px) * step(abs(g.y), 5.0));
    float front = step(g.x, w);
    lines = max(lines, stroke(box(g, vec2(-1.0, -uHalfMouth - 0.6), vec2(1.0, uHalfMouth + 0.6)), w, px) * front);
    lines = max(lines, stroke(box(g, vec2(-2.4, -uHalfMouth - 2.0), vec2(2.4, uHalfMouth + 2.0)), w, px) * front);
    c = mix(c, uLine, 0.85 * lines);

    // Where the robot reaches, and what came of the balls there.
    vec2 r = inAxes(p, uRobot.xyz);
    if (uRobot.w > 0.003) {
        float edge = box(r, uReach.xz, uReach.yw);
        float inside = clamp(-edge / px + 0.5, 0.0, 1.0);
        vec3 tint = vec3(0.35, 0.75, 1.0);
        c = mix(c, tint, uRobot.w * (0.10 * inside + 0.7 * stroke(edge, 0.012, px)));
    }
    if (uHeatShare > 0.003) {
        vec2 cell = (r - uReach.xz) / (uReach.yw - uReach.xz);
        if (all(greaterThan(cell, vec2(0.0))) && all(lessThan(cell, vec2(1.0)))) {
            vec4 heat = texture(uHeat, vec2(cell.y, cell.x));
            vec2 within = abs(fract(vec2(cell.y, cell.x) * uCells) - 0.5);
            float tile = 1.0 - smoothstep(0.42, 0.46, max(within.x, within.y));
            c = mix(c, pow(heat.rgb, vec3(2.2)) * 0.6, uHeatShare * heat.a * tile);
        }
    }
    vec3 n = vec3(0.0, 0.0, 1.0);
    float lit = sunlit(vPos, n);
    vec3 light = uSkyColor * 0.9 + uSunColor * uSun.z * lit;
    color = vec4(screen(hazed(c * light, vPos)), 1.0);
}
