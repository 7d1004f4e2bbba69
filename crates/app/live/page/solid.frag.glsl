in vec3 vPos;
in vec3 vNormal;
in vec3 vLocal;
flat in vec4 vColor;
uniform float uAlpha;
out vec4 color;

const float GOLD = 1.618034;

// A football: 12 pentagons at the corners of an icosahedron, 20 hexagons between them. The nearest face of the truncated icosahedron
// is the one whose plane is met first; the two planes' distances are 2.3274 and 2.2673 edges.
void face(vec3 n, vec3 axis, float plane, float dark, inout vec3 best) {
    float d = dot(n, normalize(axis)) / plane;
    if (d > best.x) best = vec3(d, best.x, dark);
    else best.y = max(best.y, d);
}

vec3 football(vec3 n) {
    vec3 best = vec3(-2.0, -2.0, 0.0);
    vec3 a = abs(n);
    // By symmetry the faces of one octant and its neighbors are enough.
    for (int k = 0; k < 2; k++) {
        float s = k == 0 ? 1.0 : -1.0;
        face(a, vec3(0.0, s, GOLD), 2.3274, 1.0, best);
        face(a, vec3(s, GOLD, 0.0), 2.3274, 1.0, best);
        face(a, vec3(GOLD, 0.0, s), 2.3274, 1.0, best);
        face(a, vec3(s / GOLD, 0.0, GOLD), 2.2673, 0.0, best);
        face(a, vec3(0.0, GOLD, s / GOLD), 2.2673, 0.0, best);
        face(a, vec3(GOLD, s / GOLD, 0.0), 2.2673, 0.0, best);
    }
    face(a, vec3(1.0, 1.0, 1.0), 2.2673, 0.0, best);
    face(a, vec3(-1.0, 1.0, 1.0), 2.2673, 0.0, best);
    face(a, vec3(1.0, -1.0, 1.0), 2.2673, 0.0, best);
    face(a, vec3(1.0, 1.0, -1.0), 2.2673, 0.0, best);
    float gap = best.x - best.y;
    float width = fwidth(gap) + 0.002;
    float seam = 1.0 - smoothstep(0.002, 0.002 + width, gap);
    vec3 c = mix(vec3(0.86), vec3(0.025, 0.03, 0.04), best.z);
    return mix(c, vec3(0.10), 0.7 * seam);
}

void main() {
    vec3 n = normalize(vNormal);
    vec3 albedo = vColor.rgb;
    float rough = 0.55, gloss = 0.35;
    int look = int(vColor.a + 0.5);
    if (look == 1) {
        albedo = football(normalize(vLocal));
        rough = 0.35;
        gloss = 0.5;
    } else if (look == 2) {
        // A face plate.
        vec3 l = normalize(vLocal);
        float plate = smoothstep(0.30, 0.34, -l.z) * (1.0 - smoothstep(0.72, 0.76, abs(l.x)));
        albedo = mix(albedo, vec3(0.012, 0.016, 0.022), plate);
        rough = mix(rough, 0.18, plate);
        gloss = mix(gloss, 0.9, plate);
    } else if (look == 3) {
        // Shines by itself: trails, arrows.
        color = vec4(albedo * (0.82 + 0.18 * n.z), uAlpha);
        return;
    } else if (look == 4) {
        rough = 0.4;
        gloss = 0.12;
    }
    color = vec4(screen(hazed(shade(albedo, rough, gloss, n, vPos), vPos)), uAlpha);
}
